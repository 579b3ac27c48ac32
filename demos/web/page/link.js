// The part of the address after '#': which scene, with which settings.

const numbers = ['substeps', 'iterations', 'columns', 'beside'];
const words = ['solver', 'self'];

export function readLink(hash = location.hash) {
  const parts = new URLSearchParams(hash.replace(/^#/, ''));
  const settings = { scene: parts.get('scene') ?? '', paused: parts.has('paused') };
  for (const name of words) { settings[name] = parts.get(name) ?? ''; }
  for (const name of numbers) {
    const value = Number.parseInt(parts.get(name) ?? '', 10);
    settings[name] = Number.isFinite(value) ? Math.min(Math.max(value, 0), 1000) : 0;
  }
  const gravity = Number.parseFloat(parts.get('gravity') ?? '');
  if (Number.isFinite(gravity)) { settings.gravity = Math.min(Math.max(gravity, 0), 100); } // else the scene's own
  return settings;
}

export function makeLink(settings) {
  if (!settings.scene) { return '#'; }
  const parts = new URLSearchParams({ scene: settings.scene });
  for (const name of words) {
    if (settings[name]) { parts.set(name, settings[name]); }
  }
  for (const name of numbers) {
    if (settings[name] > 0) { parts.set(name, settings[name]); }
  }
  if (settings.gravity !== undefined) { parts.set('gravity', settings.gravity); }
  return `#${parts}`;
}
