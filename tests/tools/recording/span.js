// How much of the canvas the arm takes, in width and in height.
() => {
  const canvas = document.getElementById("arm"), c = canvas.getContext("2d");
  const { width, height } = canvas, data = c.getImageData(0, 0, width, height).data;
  let x0 = width, x1 = 0, y0 = height, y1 = 0;
  for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) {
    const i = 4 * (y * width + x);
    if (data[i] > 150 && data[i + 3] > 100) {
      x0 = Math.min(x0, x); x1 = Math.max(x1, x); y0 = Math.min(y0, y); y1 = Math.max(y1, y);
    }
  }
  return [(x1 - x0) / width, (y1 - y0) / height];
}
