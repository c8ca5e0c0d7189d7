// Every family beside levels of detail of the mesh: the level whose picture is as wrong, and what it costs; the level that
// costs as much, and how wrong it is. Markdown on stdout, at each height in pixels.
//
//   node tools/lod_equal.mjs DRIVER FOLDER [--character C] [--clip CLIP] [--families R;R] [--heights 30,60,120,240]
//   node tools/lod_equal.mjs DRIVER FOLDER --tiny    two families, two levels, one height, to see that it runs
//
// FOLDER keeps what was measured (quality.json, HEIGHT.json): ended and started again, it goes on where it was.
// Error: the mean of FLIP over the box around the figure, over views and moments, against the whole mesh in its own pose; what
// shows stored frames is judged with them. Cost: process CPU time on a software rasteriser, else GPU time, all drawn in turn in
// the same rounds, of a crowd whose figures are that tall. Between the levels that are measured, error and cost are taken to run
// straight, against the logarithm of the triangles and against the triangles. Intervals: 95 %, bootstrap over views or rounds.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { asks } from './driver.mjs';

function usage(message) {
  console.error(`lod_equal: ${message}\nusage: lod_equal.mjs DRIVER FOLDER [--character C] [--clip CLIP] [--families R;R] ` +
    '[--heights H,H] | --tiny');
  process.exit(2);
}
const [driver, folder, ...rest] = process.argv.slice(2);
if (!driver || !folder) usage('the driver and a folder are needed');
const tiny = rest.length === 1 && rest[0] === '--tiny';
const call = asks(driver);
const given = { '--character': 'mannequin', '--clip': '', '--families': '', '--heights': '30,60,120,240' };
for (let i = 0; i < rest.length && !tiny; i += 2) {
  if (!(rest[i] in given) || rest[i + 1] === undefined) usage(`'${rest[i]}' is not understood`);
  given[rest[i]] = rest[i + 1];
}
const types = call('info', '--representations');
const reference = types.find((t) => t.reference).name;
const families = tiny ? ['flat:views=sphere-4x1,frames=2', 'rigid:poses=2']
  : given['--families'] ? given['--families'].split(';') : types.filter((t) => !t.reference && t.stands_alone).map((t) => t.name);
const character = tiny ? 'mannequin:triangles=500' : given['--character'];
const whole = call('inspect', character).triangles;
// The whole mesh is the finest level.
const coarser = (list) => [whole, ...list.filter((n) => n < whole)];
const levels = coarser(tiny ? [300, 100] : [3000, 2000, 1400, 1000, 700, 500, 350, 250, 175, 120, 80]);
const timed = tiny ? levels : coarser([3000, 2000, 1000, 500, 250, 120]);  // of them; cost runs straight in between
const heights = tiny ? [30] : given['--heights'].split(',').map(Number);
if (!heights.every((h) => h >= 4 && h <= 480)) usage(`'${given['--heights']}' are not heights of 4 to 480 pixels`);
const played = ['--character', character, ...(given['--clip'] ? ['--clip', given['--clip']] : [])];
const level = (n) => (n === whole ? reference : `${reference}:triangles=${n}`);
mkdirSync(folder, { recursive: true });

function kept(name, make) {
  const path = join(folder, `${name}.json`);
  if (!existsSync(path)) writeFileSync(path, JSON.stringify(make()));
  return JSON.parse(readFileSync(path, 'utf8'));
}

// A generator of its own: the same intervals every time.
function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), state | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}
const mean = (list) => list.reduce((sum, x) => sum + x, 0) / list.length;
const median = (list) => {
  const s = [...list].sort((a, b) => a - b);
  return s.length % 2 ? s[(s.length - 1) / 2] : (s[s.length / 2 - 1] + s[s.length / 2]) / 2;
};
// `statistic` of the indices 0..count-1, and its interval; values that are not finite are the ends of the scale.
function with_interval(count, statistic) {
  const next = random(12345);
  const all = Array.from({ length: 400 }, () => statistic(Array.from({ length: count }, () => Math.floor(next() * count))));
  all.sort((a, b) => a - b);
  return { value: statistic([...Array(count).keys()]), low: all[Math.floor(0.025 * all.length)], high: all[Math.ceil(0.975 * all.length) - 1] };
}
// Where the line through (xs, ys), xs falling, first passes y; before its first point Infinity, beyond its last -Infinity.
function crossing(xs, ys, y) {
  const rises = ys[ys.length - 1] > ys[0];
  if (rises ? y < ys[0] : y > ys[0]) return Infinity;
  for (let i = 0; i + 1 < xs.length; ++i) {
    if (rises ? y > ys[i + 1] : y < ys[i + 1]) continue;
    return ys[i + 1] === ys[i] ? xs[i] : xs[i] + (y - ys[i]) / (ys[i + 1] - ys[i]) * (xs[i + 1] - xs[i]);
  }
  return -Infinity;
}
// The line's y at x; its ends go on level.
function value_at(xs, ys, x) {
  if (x >= xs[0]) return ys[0];
  for (let i = 0; i + 1 < xs.length; ++i)
    if (x >= xs[i + 1]) return ys[i] + (x - xs[i]) / (xs[i + 1] - xs[i]) * (ys[i + 1] - ys[i]);
  return ys[ys.length - 1];
}

const views = tiny ? ['--azimuth-deg', '0', '--elevation-deg', '10', '--time', '0.1,0.3']
  : ['--azimuth-deg', '0:315:45', '--elevation-deg', '10', '--time', '0.07,0.33,0.59'];
const quality = kept('quality', () => call('quality', ...played, '--height-px', heights.join(','), ...views,
  ...[...families, ...levels.map(level)].flatMap((r) => ['--representation', r])).rows);

// Figures h pixels tall, within an eighth: a band of ground 40 metres away, seen from 10 degrees above.
function scenario(h) {
  const [width, height] = tiny ? [160, 120] : [640, 480];
  const [away, band] = [40, 5];
  const fov = 2 * Math.atan(1.75 * height / (2 * away * h)) * 180 / Math.PI;
  const path = join(folder, `figures_of_${h}_px.toml`);
  writeFileSync(path, `name = "figures of ${h} px"\nseed = 1\nwidth = ${width}\nheight = ${height}\n` +
    `[crowd]\nstage = "frustum"\nstage_near = ${away - band}\nstage_far = ${away + band}\nspacing = 0.7\n` +
    `[camera]\neye = [0.0, 7.9, ${away - 0.6}]\ntarget = [0.0, 0.9, 0.0]\nfov_y_deg = ${fov.toFixed(4)}\n` +
    `[[character]]\nsource = ${JSON.stringify(character)}\n${given['--clip'] ? `clips = [${JSON.stringify(given['--clip'])}]\n` : ''}`);
  return path;
}
// Status 1 says that a picture check failed, which is no surprise of a coarse level: its error is what is measured here.
function bench(...args) {
  try {
    execFileSync(driver, ['bench', ...args], { stdio: ['ignore', 'pipe', 'pipe'] });
  } catch (error) {
    if (error.status === 1) return;
    console.error(`${String(error.stderr ?? '').trim().split('\n').pop()}\nfailed (${error.status ?? error.message}): bench ${args.join(' ')}`);
    process.exit(2);
  }
}
const times = (h) => kept(`${h}`, () => {
  const store = join(folder, `${h}.sqlite`);
  rmSync(store, { force: true });  // half of a run cannot be paired with another's rounds
  bench(scenario(h), '--agents', tiny ? '5' : '80', '--occupancy', '0', '--no-floors',
    '--rounds', tiny ? '20' : '24', '--budget-ms', '100000', '--time-limit', '600', '--out', store,
    ...[...families, ...timed.slice(1).map(level)].flatMap((r) => ['--representation', r]));
  execFileSync(driver, ['report', store, '--json-out', join(folder, `${h}.rows.json`)]);
  const { runs, measurements } = JSON.parse(readFileSync(join(folder, `${h}.rows.json`), 'utf8'));
  const out = { headline: runs[0].headline, renderer: runs[0].gl_renderer };
  for (const m of measurements) {
    if (!m.samples.length) throw new Error(`${m.representation} at ${h} px: not timed (${m.status}: ${m.reason})`);
    out[m.representation] = { samples: m.samples.map((s) => s[`${runs[0].headline}_ns`] ?? s.frame_ns) };
  }
  return out;
});

const last = (list) => list[list.length - 1];
const count_within = (list) => (x) => (x === Infinity ? `> ${list[0]}` : x === -Infinity ? `< ${last(list)}` : `${Math.round(x)}`);
const cell = (s, text) => `${text(s.value)} [${text(s.low)} .. ${text(s.high)}]`;
const logs = levels.map(Math.log);
const flips = (r, h) => quality.filter((row) => row.representation === r && row.height_px === h).map((row) => row.flip.mean);
const names = quality.map((row) => row.representation);  // canonical

console.log('| representation | height, px | FLIP | level of equal FLIP, triangles | its time over the representation\'s | ' +
  'level of equal time, triangles | its FLIP | cheaper at equal FLIP |');
console.log('|---|---|---|---|---|---|---|---|');
for (const family of [...new Set(names)].filter((r) => !levels.map(level).includes(r)))
  for (const h of heights) {
    const own = flips(family, h);
    const curves = levels.map((n) => flips(level(n), h));
    const equal_error = with_interval(own.length, (picked) => {
      const at = (list) => mean(picked.map((i) => list[i]));
      return Math.exp(crossing(logs, curves.map(at), at(own)));
    });
    for (const end of ['value', 'low', 'high']) if (equal_error[end] === 0) equal_error[end] = -Infinity;
    const t = times(h);
    const rounds = t[family].samples.length;
    const costs = timed.map((n) => t[level(n)].samples);
    const time_of_level = (picked, n) => value_at(timed, costs.map((c) => median(picked.map((i) => c[i]))), n);
    const factor = with_interval(rounds, (picked) =>
      time_of_level(picked, equal_error.value) / median(picked.map((i) => t[family].samples[i])));
    const equal_time = with_interval(rounds, (picked) =>
      crossing(timed, costs.map((c) => median(picked.map((i) => c[i]))), median(picked.map((i) => t[family].samples[i]))));
    // Beyond the levels that were timed, the last of them says on which side.
    const at = Math.max(last(timed), Math.min(timed[0], equal_time.value));
    const its_flip = (Number.isFinite(equal_time.value) ? '' : equal_time.value > 0 ? '< ' : '> ') +
      value_at(logs, curves.map(mean), Math.log(at)).toFixed(4);
    const winner = factor.low > 1 ? family.split(':')[0] : factor.high < 1 ? 'the level' : 'neither';
    console.log(`| ${family} | ${h} | ${mean(own).toFixed(4)} | ${cell(equal_error, count_within(levels))} | ` +
      `${cell(factor, (x) => x.toFixed(2))} | ${cell(equal_time, count_within(timed))} | ${its_flip} | ${winner} |`);
  }
const { renderer, headline } = times(heights[0]);
console.log(`\n${character}; ${headline} time, ${renderer}.`);
