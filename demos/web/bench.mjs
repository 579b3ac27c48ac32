// Runs scenes in the page's module without a browser. usage: node bench.mjs FOLDER SCENES FRAMES
// SCENES: JSON, [[scene, settings of the page]]. Prints one JSON list: the time of all steps of each, ms.

import { readFile } from 'node:fs/promises';
import { pathToFileURL } from 'node:url';

const [folder, scenes, frames] = process.argv.slice(2);
globalThis.fetch = async (path) => new Response(await readFile(`${folder}/${path}`));
const { loadEngine } = await import(pathToFileURL(`${folder}/engine.js`));
const engine = await loadEngine();
const sums = JSON.parse(scenes).map(([scene, settings]) => {
  engine.open(scene, settings, 1.6);
  let sum = 0;
  for (let i = 0; i < Number(frames); ++i) {
    engine.step();
    sum += engine.figures().stepMs;
  }
  return sum;
});
console.log(JSON.stringify(sums));
