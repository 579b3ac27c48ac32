// The page: what is open, its clock, and the keys.

import { loadEngine } from './engine.js';
import { fillGallery } from './gallery.js';
import { Graph } from './graph.js';
import { makeLink, readLink } from './link.js';
import { Panel } from './panel.js';
import { Pointer } from './pointer.js';
import { Renderer } from './renderer.js';
import { makeViews } from './views.js';

const find = (id) => document.getElementById(id);
const stepMs = 1000 / 60;

class Page {
  constructor(engine) {
    this.engine = engine;
    this.scenes = engine.scenes();
    this.canvas = find('canvas');
    this.renderer = new Renderer(this.canvas, (name) => engine.shader(name));
    this.graph = new Graph(find('graph'));
    this.panel = new Panel({
      pause: () => this.pause(!this.isPaused),
      step: () => this.stepOnce(),
      restart: () => this.open(this.settings),
      fit: () => this.fit(),
      change: (change) => this.change(change),
      control: (index, value) => engine.setControl(index, value),
      gravity: (value) => this.setGravity(value),
      look: (look) => this.setLook(look),
    });
    this.pointer = new Pointer(this.canvas, engine, {
      tool: () => this.panel.tool(),
      views: () => this.views,
      onProblem: (words) => this.panel.showMessage(words),
      onChange: () => { this.isStale = true; },
    });
    this.scene = null;
    this.views = makeViews(this.canvas, 1);
    this.isPaused = false;
    this.isStale = false; // the picture is not of the present
    this.lastTime = 0;
    this.behind = 0;      // ms of the scene's time that are not stepped yet
    fillGallery(find('gallery'), this.scenes);
    find('to-gallery').addEventListener('click', () => { location.hash = ''; });
    window.addEventListener('hashchange', () => this.follow());
    window.addEventListener('keydown', (event) => this.key(event));
    new ResizeObserver(() => { this.isStale = true; }).observe(this.canvas);
    this.follow();
    const tick = (time) => {
      this.tick(time);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  // Shows what the address names.
  follow() {
    const settings = readLink();
    const scene = this.scenes.find((each) => each.name.toLowerCase() === settings.scene.toLowerCase());
    find('loading').hidden = true;
    find('gallery').hidden = Boolean(scene);
    find('stage').hidden = !scene;
    find('to-gallery').hidden = !scene;
    document.title = scene ? `${scene.name} – Pliant` : 'Pliant: soft bodies in the browser';
    if (!scene) {
      this.scene = null;
      return;
    }
    this.isPaused = settings.paused;
    this.scene = scene;
    this.open(settings);
  }

  // A solver that cannot run the scene is told, and the one before stays.
  open(settings) {
    this.panel.showMessage('');
    try {
      this.run(settings);
    } catch (error) {
      if (!this.settings || this.settings.scene !== this.scene.name) { this.run({}); }
      history.replaceState(null, '', makeLink(this.settings));
      this.panel.showMessage(error.message);
    }
  }

  // Throws what the scene does not run with.
  run(settings) {
    this.fitViews(settings.beside && settings.solver !== 'btSoftBody' ? 2 : 1);
    try {
      this.engine.open(this.scene.name, settings, this.views[0].aspect);
    } catch (error) {
      this.fitViews(this.facts ? this.facts.engines.length : 1);
      throw error;
    }
    this.settings = { ...settings, scene: this.scene.name };
    this.facts = this.engine.facts();
    if (this.facts.engines.length !== this.views.length) { // one of them cannot run it
      this.fitViews(this.facts.engines.length);
      this.engine.showAll(this.views[0].aspect);
    }
    if (settings.gravity !== undefined) { this.engine.setGravity(settings.gravity); }
    this.behind = 0;
    this.graph.clear();
    this.panel.showScene(this.scene, this.facts, this.settings);
    this.panel.showMessage(this.facts.problem);
    this.panel.showPaused(this.isPaused);
    this.draw();
  }

  fitViews(count = this.views.length) {
    this.renderer.resize();
    this.views = makeViews(this.canvas, count);
  }

  change(change) {
    this.open({ ...this.settings, ...change });
    history.replaceState(null, '', makeLink(this.settings));
  }

  // While it runs.
  setGravity(gravity) {
    this.engine.setGravity(gravity);
    this.settings.gravity = gravity;
    history.replaceState(null, '', makeLink(this.settings));
  }

  setLook(look) {
    this.engine.setLook(look);
    this.isStale = true;
  }

  pause(isPaused) {
    this.isPaused = isPaused;
    this.panel.showPaused(isPaused);
  }

  step() {
    const words = this.engine.step();
    if (words) { this.panel.showMessage(words); }
    this.graph.add(this.views.map((_, run) => this.engine.figures(run).stepMs));
    this.isStale = true;
  }

  stepOnce() {
    this.pause(true);
    this.step();
    this.draw();
  }

  // Steps without the clock; what tests and pictures do.
  runFrames(count) {
    this.pause(true);
    for (let i = 0; i < count; ++i) { this.step(); }
    this.draw();
    return this.engine.hash();
  }

  fit() {
    this.fitViews();
    this.engine.showAll(this.views[0].aspect);
    this.isStale = true;
  }

  tick(time) {
    const passed = Math.min(time - this.lastTime, 100);
    this.lastTime = time;
    if (!this.scene || document.hidden) { return; }
    if (!this.isPaused) {
      this.behind = Math.min(this.behind + passed, 2 * stepMs); // slower machines see slower motion
      const end = performance.now() + 30;
      while (this.behind >= stepMs - 1 && performance.now() < end) {
        this.step();
        this.behind -= stepMs;
      }
    }
    if (this.isStale) { this.draw(); }
  }

  draw() {
    this.isStale = false;
    this.fitViews();
    this.views.forEach((view, run) => {
      this.renderer.draw(this.engine.frame(run, view.aspect, view.height / this.renderer.ratio), view);
    });
    this.panel.showTitles(this.facts.engines, this.views, this.canvas);
    this.firstPicture ??= performance.now(); // ms since the address was called
    this.panel.showFigures(this.views.map((_, run) => this.engine.figures(run)));
    this.graph.draw();
  }

  go(way) {
    const index = this.scenes.indexOf(this.scene) + way;
    location.hash = makeLink({ scene: this.scenes.at(index % this.scenes.length).name });
  }

  key(event) {
    const isField = /^(input|select|button|summary|a)$/i.test(event.target.tagName);
    if (!this.scene || event.ctrlKey || event.altKey || event.metaKey) { return; }
    const isTyped = isField && (event.key === ' ' || event.key.startsWith('Arrow'));
    if (isTyped) { return; }
    const actions = {
      ' ': () => this.pause(!this.isPaused), '.': () => this.stepOnce(), r: () => this.open(this.settings),
      n: () => this.go(1), p: () => this.go(-1), f: () => this.fit(),
      b: () => this.panel.showMessage(this.engine.shoot({ across: 0, up: 0 }, this.pointer.aspect)),
      ArrowLeft: () => this.engine.turn(-20, 0), ArrowRight: () => this.engine.turn(20, 0),
      ArrowUp: () => this.engine.turn(0, -20), ArrowDown: () => this.engine.turn(0, 20),
      '+': () => this.engine.zoom(1), '-': () => this.engine.zoom(-1),
    };
    if (/^[1-4]$/.test(event.key)) { actions[event.key] = () => this.panel.selectTool(Number(event.key) - 1); }
    const action = actions[event.key] ?? actions[event.key.toLowerCase()];
    if (!action) { return; }
    event.preventDefault();
    action();
    this.isStale = true;
  }
}

try {
  window.page = new Page(await loadEngine());
} catch (error) {
  find('loading').textContent = `This page cannot run here: ${error.message}`;
  throw error;
}
