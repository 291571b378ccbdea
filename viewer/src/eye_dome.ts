// Eye-dome lighting (Boucheny 2009): a pixel is darker the farther it lies behind its neighbours, which shows shape
// where points have no normals.
import * as THREE from "three";

const fragmentShader = /* glsl */ `
  precision highp float;
  uniform sampler2D colours, depths;
  uniform vec2 pixel;
  uniform float near, far, strength;
  uniform vec3 back;
  in vec2 at;
  out vec4 shown;
  float logDepth(vec2 uv) {
    float d = texture(depths, uv).x;
    return d >= 1.0 ? 0.0 : log2(near * far / (far - d * (far - near)));
  }
  void main() {
    float d = texture(depths, at).x;
    gl_FragDepth = d;
    if (d >= 1.0) { shown = vec4(back, 1.0); return; }
    float own = logDepth(at), sum = 0.0;
    for (int k = 0; k < 8; ++k) {
      float angle = 0.7853981 * float(k);
      float other = logDepth(at + pixel * vec2(cos(angle), sin(angle)));
      sum += other == 0.0 ? 0.0 : max(0.0, own - other);
    }
    float light = exp(-strength * sum / 8.0);
    shown = vec4(texture(colours, at).rgb * mix(0.35, 1.0, light), 1.0);
  }`;

const vertexShader = /* glsl */ `
  out vec2 at;
  void main() { at = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }`;

// Draws a scene of points with this light into the canvas, with their depth, so that lines can follow.
export class EyeDome {
  private readonly target = new THREE.WebGLRenderTarget(1, 1, { depthTexture: new THREE.DepthTexture(1, 1, THREE.UnsignedIntType) });
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.OrthographicCamera();
  private readonly material: THREE.ShaderMaterial;

  constructor() {
    this.target.texture.minFilter = this.target.texture.magFilter = THREE.NearestFilter;
    this.material = new THREE.ShaderMaterial({
      vertexShader, fragmentShader, glslVersion: THREE.GLSL3, depthFunc: THREE.AlwaysDepth,
      uniforms: {
        colours: { value: this.target.texture }, depths: { value: this.target.depthTexture },
        pixel: { value: new THREE.Vector2() }, near: { value: 1 }, far: { value: 2 }, strength: { value: 6 },
        back: { value: new THREE.Vector3() },
      },
    });
    const quad = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), this.material);
    quad.frustumCulled = false;
    this.scene.add(quad);
  }

  setBack(r: number, g: number, b: number): void {
    this.material.uniforms.back.value.set(r, g, b);
  }

  resize(width: number, height: number, radius: number): void {
    this.target.setSize(width, height);
    this.material.uniforms.pixel.value.set(radius / width, radius / height);
  }

  render(renderer: THREE.WebGLRenderer, points: THREE.Scene, camera: THREE.PerspectiveCamera): void {
    this.material.uniforms.near.value = camera.near;
    this.material.uniforms.far.value = camera.far;
    renderer.setRenderTarget(this.target);
    renderer.clear();
    renderer.render(points, camera);
    renderer.setRenderTarget(null);
    renderer.clear();
    renderer.render(this.scene, this.camera);
  }
}
