// The WebAssembly module behind functions of JavaScript.

import makeModule from './pliant_web.mjs';

const files = ['bunny.obj', 'tetra_bunny.node', 'tetra_bunny.ele', 'tetra_bunny.face', 'tetra_cube.node',
  'tetra_cube.ele', 'tetra_cube.face'];
const figureNames = ['frame', 'stepMs', 'smoothMs', 'stretch', 'speed', 'energy', 'nodes', 'links', 'faces', 'finite'];

async function fetchBytes(path) {
  const answer = await fetch(path);
  if (!answer.ok) { throw new Error(`${path}: ${answer.status}`); }
  return new Uint8Array(await answer.arrayBuffer());
}

export async function loadEngine() {
  const [wasmBinary, ...contents] = await Promise.all(
    ['pliant_web.wasm', ...files.map((file) => `data/${file}`)].map(fetchBytes));
  const module = await makeModule({ wasmBinary });
  module.FS.mkdir('/data');
  files.forEach((file, i) => module.FS.writeFile(`/data/${file}`, contents[i]));
  return new Engine(module);
}

class Engine {
  constructor(module) {
    this.module = module;
    this.numbers = module._malloc(8 * figureNames.length);
  }

  words(name, types = [], values = []) { return this.module.ccall(name, 'string', types, values); }
  get memory() { return this.module.HEAPU8.buffer; } // another one whenever it has grown

  scenes() { return JSON.parse(this.words('web_scenes')); }
  shader(name) { return this.words('web_shader', ['string'], [name]); }
  // Throws what the scene does not run with.
  open(name, { solver = '', substeps = 0, iterations = 0, self = '', columns = 0, beside = 0 }, aspect) {
    const problem = this.words('web_open',
      ['string', 'string', 'number', 'number', 'string', 'number', 'number', 'number'],
      [name, solver, substeps, iterations, self, columns, beside, aspect]);
    if (problem) { throw new Error(problem); }
  }
  // m/s², downwards.
  setGravity(gravity) { this.module._web_set_gravity(gravity); }
  setLook({ wireframe, contacts, clusters }) { this.module._web_set_look(wireframe, contacts, clusters); }
  facts() { return JSON.parse(this.words('web_facts')); }
  hash() { return this.words('web_hash'); }
  step() { return this.words('web_step'); }
  figures(run = 0) {
    this.module._web_figures(run, this.numbers);
    const values = new Float64Array(this.memory, this.numbers, figureNames.length);
    return Object.fromEntries(figureNames.map((name, i) => [name, values[i]]));
  }

  showAll(aspect) { this.module._web_show_all(aspect); }
  turn(right, down) { this.module._web_turn(right, down); }
  pan(right, down, height) { this.module._web_pan(right, down, height); }
  zoom(steps) { this.module._web_zoom(steps); }

  // Places are { across, up }, -1 to 1.
  grab({ across, up }, aspect) { return this.module._web_grab(across, up, aspect) === 1; }
  pull({ across, up }, aspect) { this.module._web_pull(across, up, aspect); }
  letGo() { this.module._web_let_go(); }
  beginCut({ across, up }, aspect) { this.module._web_begin_cut(across, up, aspect); }
  cut({ across, up }, aspect) {
    return this.words('web_cut', ['number', 'number', 'number'], [across, up, aspect]);
  }
  shoot({ across, up }, aspect) {
    return this.words('web_shoot', ['number', 'number', 'number'], [across, up, aspect]);
  }
  setControl(index, value) { this.module._web_set_control(index, value); }
  // Where the camera sees a node.
  nodePlace(soft, node, aspect) {
    this.module._web_node_place(soft, node, aspect, this.numbers);
    const [across, up] = new Float32Array(this.memory, this.numbers, 2);
    return { across, up };
  }

  // What renderer.js draws; the arrays hold until the next call.
  frame(run, aspect, height) {
    const count = this.module._web_make_frame(run, aspect, height);
    const scene = new Float32Array(this.memory, this.module._web_scene(), 58);
    const first = this.module._web_materials();
    const size = 14; // of a material, words
    const floats = new Float32Array(this.memory, first, size * count);
    const integers = new Uint32Array(this.memory, first, size * count);
    const materials = [];
    for (let i = 0; i < count; ++i) {
      const at = size * i;
      materials.push({
        front: floats.subarray(at, at + 3), back: floats.subarray(at + 3, at + 6), wire: floats[at + 6],
        gloss: floats[at + 7], grid: floats[at + 8], hasShadow: floats[at + 9] > 0,
        hollow: floats[at + 10], isOnTop: floats[at + 11] > 0,
        vertices: new Float32Array(this.memory, integers[at + 12], 9 * integers[at + 13]), count: integers[at + 13],
      });
    }
    return { scene, materials };
  }
}
