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

const looks = () => [...document.querySelectorAll('#looks input')];

export class Panel {
  // `actions`: pause, step, restart, fit, change(settings), control(index, value), gravity(value), look(switches).
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
    find('beside').addEventListener('change', (event) => actions.change({ beside: event.target.checked ? 1 : 0 }));
    for (const name of ['self', 'columns']) {
      find(name).addEventListener('change', (event) => {
        actions.change({ [name]: name === 'self' ? event.target.value : Number(event.target.value) });
      });
    }
    find('gravity').addEventListener('input', (event) => {
      event.target.nextElementSibling.value = event.target.value;
      actions.gravity(Number(event.target.value));
    });
    for (const box of looks()) {
      box.addEventListener('change', () => {
        actions.look(Object.fromEntries(looks().map(({ name, checked }) => [name, checked ? 1 : 0])));
      });
    }
    find('copy').addEventListener('click', () => this.copyLink());
    for (const [key, [label]] of [['engine', ['Engine']], ...Object.entries(labels)]) {
      const term = document.createElement('dt'), value = document.createElement('dd');
      term.textContent = label;
      value.id = `figure-${key}`;
      find('figures').append(term, value);
    }
  }

  showScene(scene, facts, settings) {
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
    find('beside').checked = Boolean(settings.beside) && facts.solver !== 'btSoftBody';
    find('beside').disabled = facts.solver === 'btSoftBody';
    find('gravity').value = find('gravity').nextElementSibling.value = settings.gravity ?? facts.gravity;
    const hasSelf = facts.self_collision !== '' && facts.solver !== 'btSoftBody';
    for (const element of [find('self'), find('self').labels[0]]) { element.hidden = !hasSelf; }
    for (const element of [find('columns'), find('columns').labels[0]]) { element.hidden = !scene.has_resolution; }
    find('self').value = facts.self_collision;
    const columns = String(settings.columns ?? 0);
    find('columns').value = [...find('columns').options].some(({ value }) => value === columns) ? columns : '0';
    this.showControls(facts.controls);
  }

  // Names of the engines, when there are two also over their pictures.
  showTitles(engines, views, canvas) {
    if (find('titles').childElementCount !== engines.length) {
      find('titles').replaceChildren(...engines.map(() => document.createElement('span')));
    }
    find('titles').hidden = engines.length < 2;
    find('figure-engine').textContent = engines.join(' · ');
    [...find('titles').children].forEach((title, i) => {
      title.textContent = engines[i];
      title.style.left = `${100 * (views[i].left + views[i].width / 2) / canvas.width}%`;
      title.style.top = `${100 * (1 - (views[i].bottom + views[i].height) / canvas.height)}%`;
    });
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

  // Of each engine.
  showFigures(figures) {
    for (const [key, [, format]] of Object.entries(labels)) {
      const values = figures.map((each) => format(each[key]));
      find(`figure-${key}`).textContent = new Set(values).size === 1 ? values[0] : values.join(' · ');
    }
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
