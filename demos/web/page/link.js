// The part of the address after '#': which scene, with which settings.

const numbers = ['substeps', 'iterations'];

export function readLink(hash = location.hash) {
  const parts = new URLSearchParams(hash.replace(/^#/, ''));
  const settings = { scene: parts.get('scene') ?? '', solver: parts.get('solver') ?? '', paused: parts.has('paused') };
  for (const name of numbers) {
    const value = Number.parseInt(parts.get(name) ?? '', 10);
    settings[name] = Number.isFinite(value) ? Math.min(Math.max(value, 0), 1000) : 0;
  }
  return settings;
}

export function makeLink(settings) {
  if (!settings.scene) { return '#'; }
  const parts = new URLSearchParams({ scene: settings.scene });
  if (settings.solver) { parts.set('solver', settings.solver); }
  for (const name of numbers) {
    if (settings[name] > 0) { parts.set(name, settings[name]); }
  }
  return `#${parts}`;
}
