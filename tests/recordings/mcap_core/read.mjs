// Reads recordings with the MCAP library of JavaScript, as Foxglove does: node read.mjs FILE.mcap ...
// Prints for every file the messages per topic, the chunks, the metadata records and the first numbers of the waveform, as JSON.
import { open } from "node:fs/promises";

import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import lz4 from "@foxglove/wasm-lz4";
import zstd from "@foxglove/wasm-zstd";
import { McapIndexedReader } from "@mcap/core";
import { FileHandleReadable } from "@mcap/nodejs";

await Promise.all([lz4.isLoaded, zstd.isLoaded]);
const decompressHandlers = {
  lz4: (data, size) => lz4(data, Number(size)),
  zstd: (data, size) => zstd.decompress(data, Number(size)),
};

async function about(path) {
  const file = await open(path, "r");
  const reader = await McapIndexedReader.Initialize({ readable: new FileHandleReadable(file), decompressHandlers });
  const decoders = new Map();
  const counts = {};
  let waveform;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    if (!decoders.has(channel.id)) {
      decoders.set(channel.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
    }
    const decoded = decoders.get(channel.id).readMessage(message.data);
    counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
    if (waveform == undefined && channel.topic.endsWith("outer_ring/vibration")) {
      const samples = new DataView(decoded.data.buffer, decoded.data.byteOffset);
      waveform = {
        fields: decoded.fields.map((field) => field.name),
        width: decoded.width,
        ay: [0, 1, 2, 3].map((k) => samples.getFloat32(k * decoded.point_step + 8, true)),
      };
    }
  }
  const metadata = [];
  for await (const record of reader.readMetadata()) {
    metadata.push(record.name);
  }
  await file.close();
  return { profile: reader.header.profile, counts, chunks: reader.chunkIndexes.length, metadata, waveform };
}

const found = {};
for (const path of process.argv.slice(2)) {
  found[path] = await about(path);
}
console.log(JSON.stringify(found));
