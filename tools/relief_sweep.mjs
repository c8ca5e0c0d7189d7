// Bone-relief impostors, the source's questions crossed with each other: texture resolution (map), sampling (steps) and
// rigid artefacts (rule, capture), each cell's error against the mesh and its time beside it, as Markdown tables.
//
//   node tools/relief_sweep.mjs DRIVER FOLDER [--axis NAME=A;B;C]... [--only AXIS]
//   node tools/relief_sweep.mjs DRIVER FOLDER --tiny    two cells of a small crowd, to see that it runs
//
// FOLDER keeps every cell (FOLDER/CELL.json, CELL.sqlite): ended and started again, it goes on where it was.
// --axis: other values than the ones below; --only: vary that axis alone, the others at their last value.
import { existsSync, mkdirSync, readFileSync, renameSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { asks } from './driver.mjs';

const axes = {
  map: ['32', '64', '256', '128'],
  steps: ['4+0', '16+0', '16+7', '64+10', 'cone', 'adaptive'],  // LINEAR+BINARY of search=linear, or another search
  rule: ['dominant', 'any', 'threshold0.6', 'threshold1.2'],
  capture: ['bind', 'walk@0', 'walk@0.25', 'best'],
};

function usage(message) {
  console.error(`relief_sweep: ${message}\nusage: relief_sweep.mjs DRIVER FOLDER [--axis NAME=A;B;C]... [--only AXIS] | --tiny`);
  process.exit(2);
}
const [driver, folder, ...rest] = process.argv.slice(2);
if (!driver || !folder) usage('the driver and a folder are needed');
let only;
const tiny = rest[0] === '--tiny' && rest.length === 1;
if (tiny) Object.assign(axes, { map: ['32', '64'], steps: ['4+0'], rule: ['dominant'], capture: ['bind'] });
for (let i = 0; i < rest.length && !tiny; i += 2) {
  const [name, values] = (rest[i + 1] ?? '').split('=');
  if (!(name in axes)) usage(`there is no axis '${name}': ${Object.keys(axes).join(', ')}`);
  if (rest[i] === '--axis' && values) axes[name] = values.split(';');
  else if (rest[i] === '--only' && !values) only = name;
  else usage(`'${rest[i]} ${rest[i + 1]}' is not understood`);
}
if (only) for (const name of Object.keys(axes)) if (name !== only) axes[name] = axes[name].slice(-1);

const scenario = join(dirname(fileURLToPath(import.meta.url)), '../bench/scenarios/relief_sweep.toml');
const character = tiny ? ['--character', 'mannequin:triangles=500'] : [];
const crowd = tiny ? ['--agents', '10', '--size', '160x120'] : ['--agents', '250', '--size', '640x480'];
const views = tiny ? ['--height-px', '30', '--azimuth-deg', '0', '--time', '0.1']
  : ['--height-px', '60,120,240', '--azimuth-deg', '0,45,90', '--time', '0.1,0.6'];
mkdirSync(folder, { recursive: true });
const call = asks(driver);

function measure(cell) {
  const search = cell.steps.includes('+') ? `search=linear,steps=${cell.steps}` : `search=${cell.steps}`;
  // Every joint its own box at every size: what shares boxes changes no axis here.
  const spec = `relief:map=${cell.map},${search},rule=${cell.rule},capture=${cell.capture},merge=0,bend=rigid`;
  const name = join(folder, Object.values(cell).join('_').replace(/[^\w.+-]/g, '-'));
  if (existsSync(`${name}.json`)) return JSON.parse(readFileSync(`${name}.json`, 'utf8'));
  const { rows } = call('quality', '--representation', spec, ...character, ...views);
  const mean = (key) => rows.reduce((sum, row) => sum + row[key], 0) / rows.length;
  const { measurements } = call('bench', scenario, '--representation', spec, ...character, ...crowd,
    '--occupancy', '0.15', '--rounds', '10', '--no-floors', '--budget-ms', '60000', '--out', `${name}.sqlite`);
  const relief = measurements.find((row) => row.representation !== 'mesh');
  const mesh = measurements.find((row) => row.representation === 'mesh');
  if (relief?.status !== 'valid' || mesh?.status !== 'valid') throw new Error(`${spec}: not timed (${relief?.status}: ${relief?.reason})`);
  const result = { ...cell, iou: mean('silhouette_iou'), ssim: mean('ssim'), psnr: mean('psnr'),
    speed: mesh.cpu_ns / relief.cpu_ns, bytes: relief.texture_bytes, status: relief.status };
  writeFileSync(`${name}.part`, JSON.stringify(result));
  renameSync(`${name}.part`, `${name}.json`);
  return result;
}

let cells = [{}];
for (const [name, values] of Object.entries(axes))
  cells = cells.flatMap((cell) => values.map((value) => ({ ...cell, [name]: value })));
const results = cells.map((cell, i) => {
  process.stderr.write(`\r${i + 1} of ${cells.length}: ${Object.values(cell).join(' ')}          `);
  return measure(cell);
});
process.stderr.write('\n');

const line = (first, r) => `| ${first} | ${r.iou.toFixed(3)} | ${r.ssim.toFixed(3)} | ${r.psnr.toFixed(1)} | ${r.speed.toFixed(2)} | ${(r.bytes / 1e6).toFixed(1)} |`;
const head = (names) => `| ${names.join(' | ')} | IoU | SSIM | PSNR dB | times the mesh | MB |\n|${'---|'.repeat(names.length + 5)}`;
const varied = Object.keys(axes).filter((name) => axes[name].length > 1);
console.log(head(varied));
for (const r of results) console.log(line(varied.map((name) => r[name]).join(' | '), r));
if (varied.length > 1)
  for (const name of varied) {
    console.log(`\n${head([name])}`);
    for (const value of axes[name]) {
      const some = results.filter((r) => r[name] === value);
      const mean = (key) => some.reduce((sum, r) => sum + r[key], 0) / some.length;
      console.log(line(value, { iou: mean('iou'), ssim: mean('ssim'), psnr: mean('psnr'), speed: mean('speed'), bytes: mean('bytes') }));
    }
  }
