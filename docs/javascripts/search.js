// In a query a leading dash excludes a word; the search for an option such as --duration is for the word alone.
const post = Worker.prototype.postMessage;
Worker.prototype.postMessage = function (message, ...options) {
  const query = typeof message?.data === "string" ? { data: message.data.replace(/(^|\s)-+/g, "$1") } : {};
  return post.call(this, { ...message, ...query }, ...options);
};
