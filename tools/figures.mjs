// Makes docs/figures.md: every public figure of this project, each below the command that made it.
// Usage: ./run figures   (about five minutes on two cores; a quiet machine gives narrower intervals)
import { execFileSync } from 'node:child_process';
import { renameSync, writeFileSync } from 'node:fs';

const [driver, out] = process.argv.slice(2);
if (!driver || !out) {
  console.error('usage: figures.mjs DRIVER OUT.md');
  process.exit(2);
}

function run(args) {
  process.stderr.write(`crowdbench ${args.join(' ')}\n`);
  try {
    return JSON.parse(execFileSync(driver, [...args, '--json'], { stdio: ['ignore', 'pipe', 'ignore'], maxBuffer: 1 << 26 }));
  } catch (error) {
    if (error.status === 1 && error.stdout) return JSON.parse(error.stdout);  // void or failed: the page says so
    throw error;
  }
}

const shown = (args) => '    crowdbench ' + args.map((a) => (/[,()#]/.test(a) ? `'${a}'` : a)).join(' ') + '\n';
const number = (x, digits = 2) => (typeof x === 'number' ? x.toFixed(digits) : 'n/a');
const info = run(['info']);
const lines = [
  '# Figures',
  '',
  'Made by `./run figures`; no number on this page was typed by hand. Ratios are of process CPU time on a software rasteriser or of',
  'GPU time on hardware, interleaved in one process: above 1, the first is the faster. Intervals are bootstrap 95 %.',
  '',
  `Drawn by ${info.renderer} (${info.gl_version}).`,
  '',
  '## Speed against the mesh',
  '',
];

const speeds = [];
const pairs = [
  ['flat', 'mesh', 250], ['flat', 'mesh', 1000], ['flat', 'flat:quad=square', 1000], ['flat', 'flat:floor=1', 1000],
  ['relief', 'mesh', 100], ['relief', 'mesh', 1000], ['relief', 'relief:search=linear,steps=16+7,proxy=box', 1000],
  ['polypostor', 'mesh', 1000], ['polypostor', 'polypostor:floor=1', 1000], ['rigid', 'mesh', 1000], ['mesh', 'mesh:floor=1', 250],
];
for (const [of, to, agents] of pairs) {
  const args = ['ratio', '--of', of, '--to', to, '--agents', `${agents}`, '--occupancy', '0.15', '--size', '640x480'];
  const r = run(args);
  speeds.push([shown(args), `| ${of} | ${to} | ${agents} | ${number(r.cpu_ratio)} | ${number(r.interval?.[0])} .. ${number(r.interval?.[1])} | ` +
    `${number(r.mesh_floor?.ratio ?? r.mesh_floor)} | ${r.pairs} | ${r.void ? 'void: ' + r.reason : ''} |`]);
}
lines.push('| of | to | agents | CPU ratio | interval | mesh over its floor | pairs | |', '|---|---|---|---|---|---|---|---|');
lines.push(...speeds.map((s) => s[1]), '', ...speeds.map((s) => s[0].trimEnd()), '');

lines.push('## Quality against the mesh', '', 'One walking mannequin at the identical view, mean over azimuths 0 to 315 degrees.', '',
  '| representation | height, px | elevation | IoU | boundary, px | SSIM (crop) | PSNR, dB |', '|---|---|---|---|---|---|---|');
const commands = [];
for (const representation of ['flat', 'polypostor', 'relief']) {
  for (const elevation of ['0', '30']) {
    const args = ['quality', '--representation', representation, '--height-px', '30,60,120,240', '--azimuth-deg', '0:315:45',
      '--elevation-deg', elevation];
    const { rows } = run(args);
    commands.push(shown(args).trimEnd());
    for (const height of [30, 60, 120, 240]) {
      const some = rows.filter((r) => Math.round(r.height_px) === height);
      const mean = (key) => some.reduce((sum, r) => sum + r[key], 0) / some.length;
      lines.push(`| ${representation} | ${height} | ${elevation} | ${number(mean('silhouette_iou'), 3)} | ` +
        `${number(mean('boundary_px_mean'))} | ${number(mean('ssim'), 3)} | ${number(mean('psnr'), 1)} |`);
    }
  }
}
lines.push('', ...commands, '');

lines.push('## The switch from mesh to flat impostors', '', 'Where a texel spans that many pixels: derived, and measured from pictures.', '',
  '| pixels a texel | degrees off the axis | derived depth, m | measured, m | off by, % |', '|---|---|---|---|---|');
const switches = [];
for (const angle of ['0', '20']) {
  const args = ['switch-distance', '--off-axis-deg', angle];
  switches.push(shown(args).trimEnd());
  for (const r of run(args).rows)
    lines.push(`| ${r.ratio} | ${angle} | ${number(r.depth_m, 3)} | ${number(r.measured_depth_m, 3)} | ${number(r.measured_over_derived_percent)} |`);
}
lines.push('', ...switches, '', 'What it would show: differences over the silhouettes between the last picture before and the first after the switch.', '',
  '| pixels a texel | mesh\'s pose | | MAE mean | p95 | worst | SSIM mean | p05 | worst |', '|---|---|---|---|---|---|---|---|---|');
const pops = ['popmap', '--representation', 'flat'];
for (const size of run(pops).sizes)
  for (const [key, s] of Object.entries(size.switch)) {
    const [pose, way] = key.split('_');
    lines.push(`| ${size.ratio} | ${pose === 'own' ? 'its own' : 'the stored frame\'s'} | ${way === 'cut' ? 'cut' : 'largest step of a 4-tick fade'} | ` +
      `${[s.mae.mean, s.mae.p95, s.mae.worst].map((x) => number(x)).join(' | ')} | ` +
      `${[s.ssim_union.mean, s.ssim_union.p05, s.ssim_union.worst].map((x) => number(x, 3)).join(' | ')} |`);
  }
lines.push('', shown(pops).trimEnd(), '');
writeFileSync(`${out}.part`, lines.join('\n'));
renameSync(`${out}.part`, out);
