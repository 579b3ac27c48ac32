// All scenes with a picture each.

import { makeLink } from './link.js';

function makeElement(kind, text, parent) {
  const element = document.createElement(kind);
  element.textContent = text;
  parent.append(element);
  return element;
}

export function fillGallery(section, scenes) {
  for (const [title, wanted] of [['Scenes of Bullet’s soft-body demo', false], ['Cloth that meets itself', true]]) {
    makeElement('h2', title, section);
    const list = makeElement('ul', '', section);
    for (const scene of scenes.filter((each) => each.own === wanted)) {
      const card = makeElement('a', '', makeElement('li', '', list));
      card.href = makeLink({ scene: scene.name });
      const picture = makeElement('img', '', card);
      picture.loading = 'lazy';
      picture.alt = '';
      picture.width = 320;
      picture.height = 200;
      picture.src = `pictures/${scene.name}.jpg`;
      makeElement('strong', scene.name, card);
      makeElement('span', scene.summary, card);
    }
  }
}
