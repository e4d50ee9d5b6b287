// Pictures of the replay at a fixed frame rate, however long each of them takes to draw, and a WebM file of them.

'use strict';

// An element of a WebM file: an identifier, the length of the content, the content (a number, text or parts).
function ebml(id, content) {
  const bytes = (number, size) => Uint8Array.from({length: size}, (_, i) => Math.floor(number / 256 ** (size - 1 - i)) % 256);
  const flat = typeof content === 'number' ? [bytes(content, 8)] : typeof content === 'string' ? [new TextEncoder().encode(content)] : content.flat(Infinity);
  const length = bytes(flat.reduce((sum, part) => sum + part.length, 0), 8);
  length[0] = 1;  // the length is a number of eight bytes
  return [bytes(id, Math.ceil(Math.log2(id + 1) / 8)), length, ...flat];
}
const sizeOf = (parts) => parts.flat(Infinity).reduce((sum, part) => sum + part.length, 0);

// A WebM file of frames {time [ms], key, data} of a VP9 stream. Each key frame begins a cluster, to which players can jump.
function webm(frames, {width, height, fps}) {
  const float = (value) => [new Uint8Array(new Float64Array([value]).buffer).reverse()];
  const clusters = [];
  for (const {time, key, data} of frames) {
    if (key) clusters.push({time, blocks: []});
    const {time: start, blocks} = clusters[clusters.length - 1], after = time - start;
    blocks.push(ebml(0xA3, [Uint8Array.of(0x81, after >> 8, after & 255, key ? 0x80 : 0), data]));
  }
  const parts = clusters.map(({time, blocks}) => ebml(0x1F43B675, [ebml(0xE7, time), ...blocks]));
  const head = [
    ebml(0x1549A966, [ebml(0x2AD7B1, 1e6), ebml(0x4489, float(1000 * frames.length / fps)), ebml(0x4D80, 'Tenon'), ebml(0x5741, 'Tenon')]),
    ebml(0x1654AE6B, ebml(0xAE, [ebml(0xD7, 1), ebml(0x73C5, 1), ebml(0x83, 1), ebml(0x86, 'V_VP9'), ebml(0x23E383, Math.round(1e9 / fps)),
                                 ebml(0xE0, [ebml(0xB0, width), ebml(0xBA, height)])])),
  ];
  const cues = (from) => ebml(0x1C53BB6B, clusters.map(({time}, i) => {
    const at = from + sizeOf(parts.slice(0, i));
    return ebml(0xBB, [ebml(0xB3, time), ebml(0xB7, [ebml(0xF7, 1), ebml(0xF1, at)])]);
  }));
  const top = ebml(0x1A45DFA3, [ebml(0x4286, 1), ebml(0x42F7, 1), ebml(0x42F2, 4), ebml(0x42F3, 8), ebml(0x4282, 'webm'), ebml(0x4287, 4), ebml(0x4285, 2)]);
  return new Blob([...top, ...ebml(0x18538067, [head, cues(sizeOf(head) + sizeOf(cues(0))), parts])].flat(Infinity), {type: 'video/webm'});
}

const dataUrl = (blob) => new Promise((done) => {
  const reader = new FileReader();
  reader.onload = () => done(reader.result);
  reader.readAsDataURL(blob);
});

class Movie {
  // Shows the replay from time `from` to `to` [s] at `speed` times the real speed. Call end() afterwards.
  constructor(replay, {width, height, fps = 30, from, to, speed = 1}) {
    Object.assign(this, {replay, fps, from, to, speed, frames: []});
    this.count = Math.max(1, Math.round((to - from) / speed * fps));
    this.canvas = Object.assign(element('canvas'), {width: width & ~1, height: height & ~1});  // codecs need even sizes
    this.context = this.canvas.getContext('2d');
    replay.setSize({width: this.canvas.width, height: this.canvas.height});
  }

  timeOf(i) {
    return Math.min(this.from + i / this.fps * this.speed, this.to);
  }

  // Draws the picture at time t with time, names and scale.
  draw(t) {
    this.replay.pending = true;  // drawn here, not once more by the next animation frame
    this.replay.setTime(t);
    this.replay.render();
    this.context.drawImage(this.replay.renderer.domElement, 0, 0, this.canvas.width, this.canvas.height);
    drawNotes(this.context, this.replay, t, this.canvas.width, this.canvas.height);
  }

  png(t) {
    this.draw(t);
    return new Promise((done) => this.canvas.toBlob(done));
  }

  // Adds frame i to the video.
  async add(i) {
    const {fps, canvas: {width, height}} = this;
    if (!this.encoder) {
      this.encoder = new VideoEncoder({
        output: (chunk) => {
          const data = new Uint8Array(chunk.byteLength);
          chunk.copyTo(data);
          this.frames.push({time: Math.round(chunk.timestamp / 1000), key: chunk.type === 'key', data});
        },
        error: (error) => this.error = error,
      });
      this.encoder.configure({codec: 'vp09.00.51.08', width, height, framerate: fps, bitrate: Math.round(0.12 * width * height * fps)});
    }
    this.draw(this.timeOf(i));
    const frame = new VideoFrame(this.canvas, {timestamp: Math.round(1e6 * i / fps), duration: Math.round(1e6 / fps)});
    this.encoder.encode(frame, {keyFrame: i % Math.ceil(2 * fps) === 0});
    frame.close();
    while (this.encoder.encodeQueueSize > 2 && !this.error) await new Promise((done) => setTimeout(done, 5));
    if (this.error) throw this.error;
  }

  async file() {
    await this.encoder.flush();
    if (this.error) throw this.error;
    return webm(this.frames, {width: this.canvas.width, height: this.canvas.height, fps: this.fps});
  }

  end() {
    if (this.encoder && this.encoder.state !== 'closed') this.encoder.close();
    this.replay.setSize(null);
  }
}
