// Where a browser has no WebGL the same scene is drawn flat: each solid as one patch of its colour, the nearest last.

class FlatRenderer {
  constructor() {
    this.domElement = document.createElement("canvas");
    this.pen = this.domElement.getContext("2d");
    this.ratio = 1;
  }

  setPixelRatio(ratio) { this.ratio = ratio; }

  setClearColor(colour) { this.paper = colour.getStyle(); }

  setSize(width, height) {
    const canvas = this.domElement;
    [canvas.width, canvas.height] = [width * this.ratio, height * this.ratio].map(Math.round);
    Object.assign(canvas.style, {width: width + "px", height: height + "px"});
  }

  render(scene, camera) {
    const {pen} = this, {width, height} = this.domElement, {Matrix4, Vector3} = MeshCat.THREE, solids = [];
    scene.updateMatrixWorld();
    camera.updateMatrixWorld();
    const seen = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    const toScreen = new Matrix4(), corner = new Vector3();
    scene.traverseVisible(solid => {
      const places = solid.isMesh && solid.geometry.attributes.position;
      if (!places) return;
      toScreen.multiplyMatrices(seen, solid.matrixWorld);
      const xs = [], ys = [];
      let nearest = Infinity;
      for (let k = 0; k < places.count; k++) {
        corner.fromBufferAttribute(places, k).applyMatrix4(toScreen);
        xs.push((1 + corner.x) / 2 * width);
        ys.push((1 - corner.y) / 2 * height);
        nearest = Math.min(nearest, corner.z);
      }
      solids.push({solid, xs, ys, nearest});
    });
    solids.sort((a, b) => b.nearest - a.nearest);
    pen.globalAlpha = 1;
    pen.fillStyle = this.paper;
    pen.fillRect(0, 0, width, height);
    for (const {solid: {geometry, material}, xs, ys} of solids) {
      const faces = geometry.index.array, last = Math.min(faces.length, geometry.drawRange.count);
      pen.globalAlpha = material.transparent ? material.opacity : 1;
      pen.fillStyle = material.color.getStyle();
      pen.beginPath();
      for (let k = 0; k + 2 < last; k += 3) {  // all turned the same way, so that together they are one area
        let [a, b, c] = faces.subarray(k, k + 3);
        const turn = (xs[b] - xs[a]) * (ys[c] - ys[a]) - (xs[c] - xs[a]) * (ys[b] - ys[a]);
        if (turn < 0) [b, c] = [c, b];
        pen.moveTo(xs[a], ys[a]);
        pen.lineTo(xs[b], ys[b]);
        pen.lineTo(xs[c], ys[c]);
      }
      pen.fill();
    }
  }
}
