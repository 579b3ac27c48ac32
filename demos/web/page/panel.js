// Buttons, settings and figures beside the picture.

const find = (id) => document.getElementById(id);
const labels = {
  frame: ['Frame', (value) => value.toFixed(0)],
  smoothMs: ['Time of a step', (value) => `${value.toFixed(2)} ms`],
  stretch: ['Largest stretch', (value) => `${(100 * value).toFixed(1)} %`],
  speed: ['Speed', (value) => `${value.toFixed(2)} m/s`],
  energy: ['Kinetic energy', (value) => `${value.toPrecision(3)} J`],
  nodes: ['Nodes', (value) => value.toFixed(0)],
  links: ['Links', (value) => value.toFixed(0)],
};

export class Panel {
  // `actions`: pause, step, restart, fit, change(settings), control(index, value).
  constructor(actions) {
    this.actions = actions;
    for (const name of ['pause', 'step', 'restart', 'fit']) { find(name).addEventListener('click', actions[name]); }
    find('solver').addEventListener('change', (event) => {
      actions.change({ solver: event.target.value, substeps: 0, iterations: 0 });
    });
    for (const name of ['iterations', 'substeps']) {
      const slider = find(name);
      slider.addEventListener('input', () => { slider.nextElementSibling.value = slider.value; });
      slider.addEventListener('change', () => actions.change({ [name]: Number(slider.value) }));
    }
    find('copy').addEventListener('click', () => this.copyLink());
    for (const [key, [label]] of Object.entries(labels)) {
      const term = document.createElement('dt'), value = document.createElement('dd');
      term.textContent = label;
      value.id = `figure-${key}`;
      find('figures').append(term, value);
    }
  }

  showScene(scene, facts) {
    find('name').textContent = scene.name;
    find('summary').textContent = scene.summary;
    find('solver').value = facts.solver;
    for (const name of ['iterations', 'substeps']) {
      const slider = find(name);
      slider.max = Math.max(Number(slider.max), facts[name]);
      slider.value = facts[name];
      slider.nextElementSibling.value = facts[name];
    }
    find('iterations').disabled = facts.solver === 'btSoftBody';
    find('substeps').disabled = facts.solver !== 'xpbd';
    this.showControls(facts.controls);
  }

  // Sliders of the scene's own.
  showControls(controls) {
    find('controls').replaceChildren(...controls.map((control, index) => {
      const row = document.createElement('div');
      row.className = 'control';
      const label = document.createElement('label'), slider = document.createElement('input');
      const output = document.createElement('output');
      label.textContent = control.name;
      label.htmlFor = slider.id = `control-${index}`;
      Object.assign(slider, {
        type: 'range', min: control.low, max: control.high, step: (control.high - control.low) / 100,
      });
      slider.value = control.value;
      const show = () => { output.value = Number(slider.value).toPrecision(3); };
      slider.addEventListener('input', () => {
        show();
        this.actions.control(index, Number(slider.value));
      });
      show();
      row.append(label, slider, output);
      return row;
    }));
  }

  showFigures(figures) {
    for (const [key, [, format]] of Object.entries(labels)) { find(`figure-${key}`).textContent = format(figures[key]); }
  }

  showPaused(isPaused) { find('pause').textContent = isPaused ? 'Run' : 'Pause'; }

  showMessage(words) {
    const message = find('message');
    message.textContent = words;
    message.hidden = !words;
  }

  tool() { return document.querySelector('input[name=tool]:checked').value; }
  selectTool(index) { document.querySelectorAll('input[name=tool]')[index]?.click(); }

  async copyLink() {
    const status = document.querySelector('#link [role=status]');
    try {
      await navigator.clipboard.writeText(location.href);
      status.textContent = 'Copied.';
    } catch {
      status.textContent = 'The address bar has it.'; // pages without a secure origin have no clipboard
    }
  }
}
