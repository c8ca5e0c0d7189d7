// The mannequin with long hair of masked cards, as games have it, and what impostors make of it: Markdown on stdout.
//
//   node tools/masked_hair.mjs DRIVER FOLDER           writes FOLDER/haired.glb and scores every family on it
//   node tools/masked_hair.mjs DRIVER FOLDER --tiny    one family, one view, to see that it runs
//
// Hair: two rings of cards that hang from the crown and sway with the head, both sides drawn, one picture of strands whose
// lengths, widths and gaps are hashed. Scores against the mesh: means over four views of how much the silhouettes have in
// common, of SSIM and of FLIP; stored frames are judged with the rest.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { deflateSync } from 'node:zlib';
import { asks } from './driver.mjs';

const [driver, folder, ...rest] = process.argv.slice(2);
if (!driver || !folder || (rest.length > 0 && rest.join(' ') !== '--tiny')) {
  console.error('usage: masked_hair.mjs DRIVER FOLDER [--tiny]');
  process.exit(2);
}
const tiny = rest.length > 0;

// [0, 1) by index, the same everywhere.
function hashed(i) {
  let h = Math.imul(i + 1, 0x9E3779B1) >>> 0;
  h = Math.imul(h ^ (h >>> 15), 0x85EBCA77) >>> 0;
  return ((h ^ (h >>> 13)) >>> 0) / 2 ** 32;
}

// RGBA: strands that hang from the upper edge, each of its own width, length and brightness.
function strands(width, height) {
  const texels = Buffer.alloc(width * height * 4);
  let x = 0;
  for (let strand = 0; x < width; ++strand) {
    const wide = 2 + Math.floor(4 * hashed(3 * strand));
    const long = height * (0.55 + 0.45 * hashed(3 * strand + 1));
    const tone = 0.6 + 0.4 * hashed(3 * strand + 2);
    for (let i = 0; i < wide && x < width; ++i, ++x) {
      for (let y = 0; y < height; ++y) {
        const taper = y < 0.8 * long || i > 0;  // the last fifth of a strand is thinner
        texels.set([90 * tone, 52 * tone, 30 * tone, y < long && taper ? 255 : 0], 4 * (y * width + x));
      }
    }
    x += 1 + Math.floor(2 * hashed(5000 + strand));
  }
  return texels;
}

// Of PNG's chunks; the zlib of older Node versions keeps its own to itself.
function crc32(bytes) {
  let crc = 0xFFFFFFFF;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; ++bit) crc = (crc >>> 1) ^ (crc & 1 ? 0xEDB88320 : 0);
  }
  return (crc ^ 0xFFFFFFFF) >>> 0;
}

function png(width, height, texels) {
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]);
    const out = Buffer.alloc(body.length + 8);
    out.writeUInt32BE(data.length, 0);
    body.copy(out, 4);
    out.writeUInt32BE(crc32(body), body.length + 4);
    return out;
  };
  const head = Buffer.from([0, 0, 0, 0, 0, 0, 0, 0, 8, 6, 0, 0, 0]);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  const rows = [];
  for (let y = 0; y < height; ++y) rows.push(Buffer.from([0]), texels.subarray(4 * y * width, 4 * (y + 1) * width));
  return Buffer.concat([Buffer.from('\x89PNG\r\n\x1a\n', 'latin1'), chunk('IHDR', head),
    chunk('IDAT', deflateSync(Buffer.concat(rows))), chunk('IEND', Buffer.alloc(0))]);
}

// A card a strip of quads: from the crown outwards, then down to the shoulders. top: height of the crown, metres.
function cards(top, middle) {
  const mesh = { positions: [], normals: [], uvs: [], indices: [] };
  const profile = [[0.01, 0.014], [0.07, 0.008], [0.106, -0.05], [0.118, -0.15], [0.128, -0.28], [0.14, -0.42]];
  const count = 14;
  for (let ring = 0; ring < 2; ++ring) {
    for (let card = 0; card < count; ++card) {
      const turn = 2 * Math.PI * (card + 0.5 * ring) / count;
      if (Math.cos(turn) > 0.75) continue;  // the face looks out
      const first = mesh.positions.length / 3;
      profile.forEach(([out, down], row) => {
        for (const side of [-1, 1]) {
          const angle = turn + side * (0.24 + 0.02 * hashed(100 * ring + card));
          const reach = out * (1 - 0.07 * ring);
          mesh.positions.push(reach * Math.sin(angle), top + down, middle + reach * Math.cos(angle));
          mesh.normals.push(Math.sin(turn), 0, Math.cos(turn));
          mesh.uvs.push(0.25 * (card % 4) + (side > 0 ? 0.25 : 0), row / (profile.length - 1));
        }
        if (row === 0) return;
        const a = first + 2 * (row - 1);
        mesh.indices.push(a, a + 2, a + 1, a + 1, a + 2, a + 3);
      });
    }
  }
  return mesh;
}

function chunks_of(file) {
  const bytes = readFileSync(file);
  const length = bytes.readUInt32LE(12);
  return { json: JSON.parse(bytes.subarray(20, 20 + length)), bin: bytes.subarray(28 + length) };
}

function write_glb(file, json, bin) {
  const padded = (data, by) => Buffer.concat([data, Buffer.alloc((4 - data.length % 4) % 4, by)]);
  const text = padded(Buffer.from(JSON.stringify(json)), ' ');
  const data = padded(bin, 0);
  const head = Buffer.alloc(20);
  [0x46546C67, 2, 28 + text.length + data.length, text.length, 0x4E4F534A].forEach((v, i) => head.writeUInt32LE(v, 4 * i));
  const second = Buffer.alloc(8);
  [data.length, 0x004E4942].forEach((v, i) => second.writeUInt32LE(v, 4 * i));
  writeFileSync(file, Buffer.concat([head, text, second, data]));
}

function add_hair(from, to) {
  const { json, bin } = chunks_of(from);
  const parts = [bin];
  let size = bin.length;
  const view = (data) => {
    const padding = Buffer.alloc((4 - size % 4) % 4);
    parts.push(padding, data);
    json.bufferViews.push({ buffer: 0, byteOffset: size + padding.length, byteLength: data.length });
    size += padding.length + data.length;
    return json.bufferViews.length - 1;
  };
  const accessor = (array, componentType, type, components) => {
    const bounds = type !== 'VEC3' ? {} : {
      min: [0, 1, 2].map((k) => Math.min(...array.filter((_, i) => i % 3 === k))),
      max: [0, 1, 2].map((k) => Math.max(...array.filter((_, i) => i % 3 === k))) };
    json.accessors.push({ bufferView: view(Buffer.from(array.buffer)), componentType, count: array.length / components, type,
      ...bounds });
    return json.accessors.length - 1;
  };
  const top = Math.max(...json.meshes[0].primitives.map((p) => json.accessors[p.attributes.POSITION].max[1]));
  const head = json.skins[0].joints.findIndex((node) => json.nodes[node].name === 'head');
  const mesh = cards(top, 0.0);
  const count = mesh.positions.length / 3;
  const hung = (value, Type) => Type.from({ length: 4 * count }, (_, i) => (i % 4 === 0 ? value : 0));
  const width = 128;
  const height = 256;
  json.images.push({ mimeType: 'image/png', bufferView: view(png(width, height, strands(width, height))) });
  json.textures.push({ source: json.images.length - 1 });
  json.materials.push({ name: 'strands', alphaMode: 'MASK', alphaCutoff: 0.5, doubleSided: true,
    pbrMetallicRoughness: { baseColorTexture: { index: json.textures.length - 1 }, metallicFactor: 0 } });
  json.meshes[0].primitives.push({ material: json.materials.length - 1, attributes: {
    POSITION: accessor(Float32Array.from(mesh.positions), 5126, 'VEC3', 3),
    NORMAL: accessor(Float32Array.from(mesh.normals), 5126, 'VEC3', 3),
    TEXCOORD_0: accessor(Float32Array.from(mesh.uvs), 5126, 'VEC2', 2),
    JOINTS_0: accessor(hung(head, Uint16Array), 5123, 'VEC4', 4),
    WEIGHTS_0: accessor(hung(1, Float32Array), 5126, 'VEC4', 4) },
  indices: accessor(Uint16Array.from(mesh.indices), 5123, 'SCALAR', 1) });
  json.buffers[0].byteLength = size;
  write_glb(to, json, Buffer.concat(parts));
}

if (!existsSync(folder)) mkdirSync(folder);
const plain = join(folder, 'plain.glb');
const haired = join(folder, 'haired.glb');
execFileSync(driver, ['inspect', 'mannequin', '--out', plain], { stdio: ['ignore', 'ignore', 'inherit'] });
add_hair(plain, haired);

const call = asks(driver);
const families = tiny ? ['rigid:poses=2']
  : call('info', '--representations').filter((t) => !t.reference && t.stands_alone).map((t) => t.name);
const heights = tiny ? '60' : '30,60,120';
const mean = (values) => values.reduce((sum, v) => sum + v, 0) / values.length;
console.log('| hair | representation | pixels | IoU of the silhouettes | SSIM | FLIP |\n|---|---|---|---|---|---|');
for (const [name, file] of [['masked cards', haired], ['none', plain]]) {
  for (const family of families) {
    const rows = call('quality', '--character', file, '--representation', family, '--height-px', heights, '--azimuth-deg',
      tiny ? '40' : '40,130,220,310', '--clip', 'walk').rows;
    for (const height of heights.split(',')) {
      const own = rows.filter((row) => row.height_px === Number(height));
      const of = (score) => mean(own.map((row) => row[score].mean ?? row[score])).toFixed(3);
      console.log(`| ${name} | ${family} | ${height} | ${of('silhouette_iou')} | ${of('ssim')} | ${of('flip')} |`);
    }
  }
}
