// Draws frames with WebGL 2, by the shaders of the program `pliant`.

const shadowSize = 2048, shadowTaps = 8, lineWidth = 1.1;
const prelude = '#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2DShadow;\n';

function makeProgram(gl, vertexText, fragmentText) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertexText], [gl.FRAGMENT_SHADER, fragmentText]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, prelude + text.replace(/^#version.*\n/, ''));
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) { throw new Error(gl.getShaderInfoLog(shader)); }
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) { throw new Error(gl.getProgramInfoLog(program)); }
  const places = new Map();
  const place = (name) => {
    if (!places.has(name)) { places.set(name, gl.getUniformLocation(program, name)); }
    return places.get(name);
  };
  return {
    use: () => gl.useProgram(program),
    number: (name, value) => gl.uniform1f(place(name), value),
    unit: (name, value) => gl.uniform1i(place(name), value),
    vector: (name, value) => gl.uniform3fv(place(name), value),
    matrix: (name, value) => gl.uniformMatrix4fv(place(name), false, value),
  };
}

export class Renderer {
  constructor(canvas, shader) {
    this.canvas = canvas;
    this.shader = shader;
    this.ratio = 1; // pixels of the picture for one of the page
    this.gl = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true });
    if (!this.gl) { throw new Error('this browser has no WebGL 2'); }
    this.prepare();
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => this.prepare());
  }

  prepare() {
    const gl = this.gl;
    const program = (name) => makeProgram(gl, this.shader(`${name} vertex`), this.shader(`${name} fragment`));
    this.depth = program('depth');
    this.body = program('body');
    this.sky = program('sky');
    this.buffers = [];
    this.empty = gl.createVertexArray();
    this.shadowMap = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadowMap);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, shadowSize, shadowSize);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
      [gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE], [gl.TEXTURE_COMPARE_FUNC, gl.LEQUAL]]) {
      gl.texParameteri(gl.TEXTURE_2D, name, value);
    }
    this.shadowTarget = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowTarget);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadowMap, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  // Fits the picture to the page.
  resize() {
    const { canvas } = this;
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(canvas.clientWidth * this.ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * this.ratio));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
  }

  upload(materials) {
    const gl = this.gl;
    materials.forEach((material, i) => {
      if (!this.buffers[i]) {
        const array = gl.createVertexArray(), buffer = gl.createBuffer();
        gl.bindVertexArray(array);
        gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
        for (let k = 0; k < 3; ++k) {
          gl.enableVertexAttribArray(k);
          gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 36, 12 * k);
        }
        this.buffers[i] = { array, buffer };
      }
      gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[i].buffer);
      gl.bufferData(gl.ARRAY_BUFFER, material.vertices, gl.STREAM_DRAW);
    });
  }

  drawMaterial(index, count) {
    this.gl.bindVertexArray(this.buffers[index].array);
    this.gl.drawArrays(this.gl.TRIANGLES, 0, count);
  }

  // Into a view of views.js.
  draw({ scene, materials }, view) {
    const gl = this.gl;
    if (gl.isContextLost()) { return; }
    const vector = (index) => scene.subarray(32 + 3 * index, 35 + 3 * index);
    this.upload(materials);
    gl.enable(gl.DEPTH_TEST);

    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowTarget);
    gl.viewport(0, 0, shadowSize, shadowSize);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(2, 4);
    this.depth.use();
    this.depth.matrix('view_projection', scene.subarray(16, 32));
    materials.forEach((material, i) => { if (material.hasShadow) { this.drawMaterial(i, material.count); } });
    gl.disable(gl.POLYGON_OFFSET_FILL);

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(view.left, view.bottom, view.width, view.height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(view.left, view.bottom, view.width, view.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.disable(gl.DEPTH_TEST);
    this.sky.use();
    ['right', 'up', 'forward', 'horizon_color', 'zenith_color'].forEach((name, i) => {
      this.sky.vector(name, vector(2 + i));
    });
    gl.bindVertexArray(this.empty);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.enable(gl.DEPTH_TEST);

    const { body } = this;
    body.use();
    gl.bindTexture(gl.TEXTURE_2D, this.shadowMap);
    body.matrix('view_projection', scene.subarray(0, 16));
    body.matrix('light_projection', scene.subarray(16, 32));
    body.vector('light_direction', vector(0));
    body.vector('eye', vector(1));
    body.vector('haze_color', vector(5));
    body.vector('haze_center', vector(7));
    body.number('haze_distance', scene[56]);
    body.number('shadow_offset', scene[57]);
    body.number('shadow_blur', 0.006);
    body.number('shadow_taps', shadowTaps);
    body.number('line_width', lineWidth * this.ratio);
    body.unit('shadow_map', 0);
    let isOnTop = false;
    materials.forEach((material, i) => {
      if (material.isOnTop && !isOnTop) { gl.clear(gl.DEPTH_BUFFER_BIT); }
      isOnTop = material.isOnTop;
      body.number('hollow', material.hollow);
      body.vector('front_color', material.front);
      body.vector('back_color', material.back);
      body.number('wire', material.wire);
      body.number('gloss', material.gloss);
      body.number('grid', material.grid);
      this.drawMaterial(i, material.count);
    });
    gl.disable(gl.SCISSOR_TEST);
  }
}
