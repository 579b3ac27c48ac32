// What mouse and fingers do on the picture.

import { findView, placeIn } from './views.js';

export class Pointer {
  // `tool()` answers pull, cut, shoot or look; `views()` where engines are drawn; `onProblem(words)` is told what an
  // engine cannot do.
  constructor(canvas, engine, { tool, views, onProblem, onChange }) {
    Object.assign(this, { canvas, engine, tool, views, onProblem, onChange });
    this.view = null;         // in which the first finger went down
    this.fingers = new Map(); // by id: last place in pixels
    this.action = '';         // pull, cut, turn or pan
    canvas.addEventListener('pointerdown', (event) => this.press(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    for (const name of ['pointerup', 'pointercancel']) { canvas.addEventListener(name, (event) => this.release(event)); }
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      engine.zoom(-Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY) / 40, 3));
      onChange();
    }, { passive: false });
  }

  get aspect() { return this.views()[0].aspect; } // of each view

  shares(event) {
    const box = this.canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  place(event) { return placeIn(this.canvas, this.view, ...this.shares(event)); }

  press(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (this.fingers.size > 1) {
      this.end();
      this.action = 'pinch';
      return;
    }
    this.view = findView(this.canvas, this.views(), ...this.shares(event));
    this.action = this.choose(event);
    this.onChange();
  }

  choose(event) {
    if (event.button === 1) { return 'pan'; }
    if (event.button === 2) { return 'turn'; }
    const at = this.place(event);
    const tool = event.shiftKey ? 'cut' : this.tool();
    if (tool === 'pull' && this.engine.grab(at, this.aspect)) { return 'pull'; }
    if (tool === 'cut') {
      this.engine.beginCut(at, this.aspect);
      return 'cut';
    }
    if (tool === 'shoot') {
      this.onProblem(this.engine.shoot(at, this.aspect));
      return '';
    }
    return 'turn';
  }

  move(event) {
    const before = this.fingers.get(event.pointerId);
    if (!before) { return; }
    const now = { x: event.clientX, y: event.clientY };
    const right = now.x - before.x, down = now.y - before.y;
    if (this.action === 'pinch') { this.pinch(event.pointerId, now, right, down); }
    this.fingers.set(event.pointerId, now);
    if (this.action === 'turn') { this.engine.turn(right, down); }
    if (this.action === 'pan') { this.engine.pan(right, down, this.canvas.clientHeight); }
    if (this.action === 'pull') { this.engine.pull(this.place(event), this.aspect); }
    if (this.action === 'cut') { this.onProblem(this.engine.cut(this.place(event), this.aspect)); }
    this.onChange();
  }

  // Two fingers: their distance zooms, their middle moves the camera.
  pinch(id, now, right, down) {
    const other = [...this.fingers].find(([each]) => each !== id)?.[1];
    const before = this.fingers.get(id);
    if (!other) { return; }
    const distance = (a, b) => Math.max(Math.hypot(a.x - b.x, a.y - b.y), 1);
    this.engine.zoom(Math.log(distance(now, other) / distance(before, other)) / Math.log(1 / 0.9));
    this.engine.pan(0.5 * right, 0.5 * down, this.canvas.clientHeight);
  }

  end() {
    if (this.action === 'pull') { this.engine.letGo(); }
    this.action = '';
  }

  release(event) {
    this.fingers.delete(event.pointerId);
    if (this.action !== 'pinch' || this.fingers.size === 0) { this.end(); }
    this.onChange();
  }
}
