// Typesets the formulas that pymdownx.arithmatex marks, on the first page and on every page loaded later.
document$.subscribe(() => {
  for (const formula of document.querySelectorAll(".arithmatex")) {
    // The text is \(...\) in a line and \[...\] in a block.
    const source = formula.textContent.slice(2, -2);
    katex.render(source, formula, { displayMode: formula.tagName === "DIV", throwOnError: false });
  }
});
