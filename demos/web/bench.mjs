// Runs scenes in the page's module without a browser. usage: node bench.mjs FOLDER SCENES FRAMES
// SCENES: JSON, [[scene, settings of the page]]. Prints JSON: of each the time of every step, ms.

import { readFile } from 'node:fs/promises';
import { pathToFileURL } from 'node:url';

const [folder, scenes, frames] = process.argv.slice(2);
globalThis.fetch = async (path) => new Response(await readFile(`${folder}/${path}`));
const { loadEngine } = await import(pathToFileURL(`${folder}/engine.js`));
const engine = await loadEngine();
const steps = JSON.parse(scenes).map(([scene, settings]) => {
  engine.open(scene, settings, 1.6);
  return Array.from({ length: Number(frames) }, () => {
    engine.step();
    return engine.figures().stepMs;
  });
});
console.log(JSON.stringify(steps));
