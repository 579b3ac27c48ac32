// Curves of the last values, one for each engine.

const colors = ['#b23a18', '#1f6fb5'];

export class Graph {
  constructor(canvas, length = 240) {
    this.canvas = canvas;
    this.length = length;
    this.values = []; // of all engines, step by step
  }

  clear() { this.values = []; }

  add(values) {
    this.values.push(values);
    if (this.values.length > this.length) { this.values.shift(); }
  }

  draw() {
    const { canvas, values, length } = this;
    const pen = canvas.getContext('2d');
    const { width, height } = canvas;
    pen.clearRect(0, 0, width, height);
    if (values.length === 0) { return; }
    // The highest but for a few, so that one long step does not flatten the rest.
    const sorted = values.flat().sort((a, b) => a - b);
    const top = 1.25 * Math.max(sorted[Math.floor(0.98 * (sorted.length - 1))], 0.05);
    pen.lineWidth = 3;
    values[0].forEach((_, engine) => {
      pen.strokeStyle = colors[engine];
      pen.beginPath();
      values.forEach((all, i) => {
        const x = width * i / (length - 1), y = height - (height - 6) * Math.min(all[engine] / top, 1) - 3;
        if (i === 0) { pen.moveTo(x, y); } else { pen.lineTo(x, y); }
      });
      pen.stroke();
    });
    pen.fillStyle = '#55626f';
    pen.font = '22px system-ui, sans-serif';
    pen.fillText(`${top.toPrecision(2)} ms`, 8, 26);
    const middle = sorted[sorted.length >> 1];
    canvas.setAttribute('aria-label', `Time of a step: median ${middle.toPrecision(2)} ms of the last ${values.length}`);
  }
}
