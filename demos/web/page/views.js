// Where the picture of each engine is on the canvas: beside each other, one above the other where it is narrow.

// In pixels from the canvas's left and bottom.
export function makeViews({ width, height }, count) {
  const isWide = width >= height;
  const wide = isWide ? Math.floor(width / count) : width, high = isWide ? height : Math.floor(height / count);
  return Array.from({ length: count }, (_, i) => ({
    left: isWide ? i * wide : 0, bottom: isWide ? 0 : (count - 1 - i) * high, width: wide, height: high,
    aspect: wide / high,
  }));
}

// x and y: shares of the canvas from its left and top.
export function findView(canvas, views, x, y) {
  const right = x * canvas.width, up = (1 - y) * canvas.height;
  return views.find(({ left, bottom, width, height }) =>
    right >= left && right < left + width && up >= bottom && up < bottom + height) ?? views[0];
}

// -1 to 1 from the view's left to right and bottom to top.
export function placeIn(canvas, view, x, y) {
  return {
    across: 2 * (x * canvas.width - view.left) / view.width - 1,
    up: 2 * ((1 - y) * canvas.height - view.bottom) / view.height - 1,
  };
}
