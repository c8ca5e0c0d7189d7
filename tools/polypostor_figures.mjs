// usage: node tools/polypostor_figures.mjs DRIVER memory|quality|flicker|characters|speed|bake [--quick] [FILE...]
// Prints a table of renderers/polypostor/README.md: bytes against flat impostors, quality against the mesh, flicker,
// the same for the glTF files named, speed, bake time. --quick: few views and frames, to see that it runs.
import { execFileSync } from 'node:child_process'
import { basename } from 'node:path'

const tables = ['memory', 'quality', 'flicker', 'characters', 'speed', 'bake']
const [driver, table, ...rest] = process.argv.slice(2)
if (!driver || !tables.includes(table)) {
  console.error(`usage: node tools/polypostor_figures.mjs DRIVER ${tables.join('|')} [--quick] [FILE...]`)
  process.exit(2)
}
const quick = rest.includes('--quick')
const files = rest.filter((r) => r !== '--quick')
const run = (...args) =>
  JSON.parse(execFileSync(driver, [...args, '--json'], { maxBuffer: 1 << 28, stdio: ['ignore', 'pipe', 'ignore'] }))
const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length

// Stored views and frames: 17 azimuths by 8 elevations, ten frames of 1.06 s.
const cycle = 1.06
const moments = (count) => Array.from({ length: count }, (_, f) => (f * cycle / count).toFixed(4))
const azimuths = quick ? '0' : [0, 2, 4, 6, 9, 11, 13, 15].map((k) => (k * 360 / 17).toFixed(5)).join(',')
const elevations = quick ? '0' : [0, 1, 3].map((k) => (k * 90 / 7).toFixed(5)).join(',')
const views = ['--height-px', '120,60', '--azimuth-deg', azimuths, '--elevation-deg', elevations]

if (table === 'memory') {
  const mib = (bytes) => (bytes / (1 << 20)).toFixed(2)
  const bytesOf = (spec, clips) => run('bake', '--representation', spec, '--bake-budget', '16384', ...clips.flatMap((c) => ['--clip', c]))
  console.log('| views | frames | clips | key | vertices | images MiB | polygons MiB | square flat MiB | trimmed flat MiB | square / this | trimmed / this |')
  console.log('|---|---|---|---|---|---|---|---|---|---|---|')
  const row = (grid, frames, clips, key, vertices) => {
    const p = bytesOf(`polypostor:views=${grid},frames=${frames},key=${key},vertices=${vertices}`, clips)
    const [square, trimmed] = ['square', 'trimmed'].map(
      (quad) => bytesOf(`flat:views=${grid},frames=${frames},quad=${quad}`, clips).gpu_bytes)
    console.log(`| ${grid} | ${frames} | ${clips.join(', ')} | ${key} | ${vertices} | ${mib(p.texture_bytes)} | ` +
      `${mib(p.buffer_bytes)} | ${mib(square)} | ${mib(trimmed)} | ${(square / p.gpu_bytes).toFixed(1)} | ` +
      `${(trimmed / p.gpu_bytes).toFixed(1)} |`)
  }
  const grid = quick ? 'sphere-4x1' : 'sphere-17x8'
  row(grid, 10, ['walk'], 'most_visible', 8)
  row(grid, quick ? 12 : 30, ['walk'], 'most_visible', 8)
  row(grid, 10, ['walk'], 'two_keys', 8)
  row(grid, 10, ['walk'], 'most_visible', 12)
  row(quick ? 'hemi-4' : 'hemi-12', 10, ['walk'], 'most_visible', 8)
  row(grid, 10, ['walk', 'run'], 'most_visible', 8)
  row(grid, quick ? 12 : 30, ['walk'], 'two_keys', 8)
}

if (table === 'quality') {
  const specs = ['polypostor', 'polypostor:key=first', 'polypostor:key=two_keys', 'flat'].slice(0, quick ? 1 : undefined)
  const { rows } = run('quality', ...specs.flatMap((s) => ['--representation', s]), ...views, '--time', moments(10).join(','))
  console.log('| representation | pixels | IoU mean | worst | SSIM | PSNR dB |\n|---|---|---|---|---|---|')
  for (const spec of specs)
    for (const height of [120, 60]) {
      const some = rows.filter((r) => r.representation === spec && r.height_px === height)
      const iou = some.map((r) => r.silhouette_iou)
      console.log(`| ${spec} | ${height} | ${mean(iou).toFixed(4)} | ${Math.min(...iou).toFixed(4)} | ` +
        `${mean(some.map((r) => r.ssim)).toFixed(4)} | ${mean(some.map((r) => r.psnr)).toFixed(2)} |`)
    }
  console.log('\n| IoU at 120 pixels, by frame |' + moments(10).map((_, f) => ` ${f} |`).join('') + '\n|---' + '|---'.repeat(10) + '|')
  for (const spec of specs)
    console.log(`| ${spec} |` + moments(10).map((t) => ' ' + mean(rows.filter((r) => r.representation === spec &&
      r.height_px === 120 && Math.abs(r.time - t) < 1e-6).map((r) => r.silhouette_iou)).toFixed(3) + ' |').join(''))
}

// Stored views and frames of every character's default clip.
if (table === 'characters') {
  const specs = ['polypostor', 'polypostor:key=first']
  console.log('| character | representation | pixels | IoU mean | worst | SSIM | PSNR dB |\n|---|---|---|---|---|---|---|')
  for (const file of ['mannequin', ...files]) {
    const clip = run('inspect', file).clips.find((c) => c.default)
    const times = moments(10).map((t) => (clip.start + t / cycle * clip.cycle_seconds).toFixed(5))
    const { rows } = run('quality', '--character', file, ...specs.flatMap((s) => ['--representation', s]), ...views,
      '--time', times.join(','))
    for (const spec of specs)
      for (const height of [120, 60]) {
        const some = rows.filter((r) => r.representation === spec && r.height_px === height)
        const iou = some.map((r) => r.silhouette_iou)
        console.log(`| ${basename(file, '.glb')} | ${spec} | ${height} | ${mean(iou).toFixed(4)} | ` +
          `${Math.min(...iou).toFixed(4)} | ${mean(some.map((r) => r.ssim)).toFixed(4)} | ` +
          `${mean(some.map((r) => r.psnr)).toFixed(2)} |`)
      }
  }
}

if (table === 'speed') {
  const crowd = ['--agents', quick ? '100' : '1000', '--occupancy', '0.15', '--size', '640x480']
  console.log('| times as fast as the mesh | process CPU | 95 % |\n|---|---|---|')
  for (const spec of ['polypostor', 'polypostor:key=two_keys', 'flat']) {
    const r = run('ratio', '--of', spec, '--to', 'mesh', ...crowd)
    console.log(`| ${spec} | ${r.cpu_ratio.toFixed(1)} | ${r.interval.map((v) => v.toFixed(1)).join(' to ')} |`)
  }
}

if (table === 'bake') {
  console.log('| bake | seconds |\n|---|---|')
  for (const key of ['first', 'most_visible', 'two_keys']) {
    const spec = `polypostor:key=${key}` + (quick ? ',views=sphere-4x1' : '')
    console.log(`| ${spec} | ${run('bake', '--representation', spec, '--no-cache').bake_seconds.toFixed(1)} |`)
  }
}

if (table === 'flicker') {
  const specs = ['polypostor', 'flat']
  const { flicker } = run('quality', '--flicker', ...specs.flatMap((s) => ['--representation', s]), ...views, '--time',
    moments(20).join(','))
  console.log('| twice the stored rate | pixels | flicker, mean | worst view |\n|---|---|---|---|')
  for (const spec of specs)
    for (const height of [120, 60]) {
      const scores = flicker.filter((r) => r.representation === spec && r.height_px === height).map((r) => r.flicker)
      console.log(`| ${spec} | ${height} | ${mean(scores).toFixed(2)} | ${Math.max(...scores).toFixed(2)} |`)
    }
}
