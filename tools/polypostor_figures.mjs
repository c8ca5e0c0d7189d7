// usage: node tools/polypostor_figures.mjs DRIVER memory|quality|flicker|characters|tears|speed|bake [--tiny] [FILE...]
// Prints a table of renderers/polypostor/README.md: bytes against flat impostors, quality against the mesh, flicker,
// the same for the glTF files named, what is torn of them, speed, bake time. --tiny: few views, frames and agents, to see that it runs.
import { basename } from 'node:path'
import { asks } from './driver.mjs'

const tables = ['memory', 'quality', 'flicker', 'characters', 'tears', 'speed', 'bake']
const [driver, table, ...rest] = process.argv.slice(2)
if (!driver || !tables.includes(table)) {
  console.error(`usage: node tools/polypostor_figures.mjs DRIVER ${tables.join('|')} [--tiny] [FILE...]`)
  process.exit(2)
}
const tiny = rest.includes('--tiny')
const files = rest.filter((r) => r !== '--tiny')
const run = asks(driver)
const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length

// Stored views and frames: 17 azimuths by 8 elevations, ten frames of 1.06 s.
const cycle = 1.06
const moments = (count) => Array.from({ length: tiny ? 4 : count }, (_, f) => (f * cycle / count).toFixed(4))
// A bake of seconds instead of half a minute.
const small = (spec) => (tiny ? `${spec}${spec.includes(':') ? ',' : ':'}views=sphere-8x2,frames=4` : spec)
const azimuths = tiny ? '0' : [0, 2, 4, 6, 9, 11, 13, 15].map((k) => (k * 360 / 17).toFixed(5)).join(',')
const elevations = tiny ? '0' : [0, 1, 3].map((k) => (k * 90 / 7).toFixed(5)).join(',')
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
  const grid = tiny ? 'sphere-4x1' : 'sphere-17x8'
  row(grid, tiny ? 2 : 10, ['walk'], 'most_visible', 8)
  if (!tiny) {
    row(grid, 30, ['walk'], 'most_visible', 8)
    row(grid, 10, ['walk'], 'two_keys', 8)
    row(grid, 10, ['walk'], 'most_visible', 12)
    row('hemi-12', 10, ['walk'], 'most_visible', 8)
    row(grid, 10, ['walk', 'run'], 'most_visible', 8)
    row(grid, 30, ['walk'], 'two_keys', 8)
  }
}

if (table === 'quality') {
  const specs = ['polypostor', 'polypostor:key=most_visible', 'polypostor:key=first', 'polypostor:key=two_keys', 'flat'].slice(0, tiny ? 1 : 5).map(small)
  const { rows, representations } = run('quality', ...specs.flatMap((s) => ['--representation', s]), ...views, '--time', moments(10).join(','))
  console.log('| representation | pixels | IoU mean | worst | SSIM | PSNR dB |\n|---|---|---|---|---|---|')
  for (const spec of representations)
    for (const height of [120, 60]) {
      const some = rows.filter((r) => r.representation === spec && r.height_px === height)
      const iou = some.map((r) => r.silhouette_iou)
      console.log(`| ${spec} | ${height} | ${mean(iou).toFixed(4)} | ${Math.min(...iou).toFixed(4)} | ` +
        `${mean(some.map((r) => r.ssim)).toFixed(4)} | ${mean(some.map((r) => r.psnr)).toFixed(2)} |`)
    }
  console.log('\n| IoU at 120 pixels, by frame |' + moments(10).map((_, f) => ` ${f} |`).join('') + '\n|---' + '|---'.repeat(moments(10).length) + '|')
  for (const spec of representations)
    console.log(`| ${spec} |` + moments(10).map((t) => ' ' + mean(rows.filter((r) => r.representation === spec &&
      r.height_px === 120 && Math.abs(r.time - t) < 1e-6).map((r) => r.silhouette_iou)).toFixed(3) + ' |').join(''))
}

// Stored views and frames of every character's default clip.
if (table === 'characters') {
  const specs = ['polypostor', 'polypostor:key=first'].map(small)
  console.log('| character | representation | pixels | IoU mean | worst | SSIM | PSNR dB |\n|---|---|---|---|---|---|---|')
  for (const file of ['mannequin', ...files]) {
    const clip = run('inspect', file).clips.find((c) => c.default)
    const times = moments(10).map((t) => (clip.start + t / cycle * clip.cycle_seconds).toFixed(5))
    const { rows, representations } = run('quality', '--character', file, ...specs.flatMap((s) => ['--representation', s]), ...views,
      '--time', times.join(','))
    for (const spec of representations)
      for (const height of [120, 60]) {
        const some = rows.filter((r) => r.representation === spec && r.height_px === height)
        const iou = some.map((r) => r.silhouette_iou)
        console.log(`| ${basename(file, '.glb')} | ${spec} | ${height} | ${mean(iou).toFixed(4)} | ` +
          `${Math.min(...iou).toFixed(4)} | ${mean(some.map((r) => r.ssim)).toFixed(4)} | ` +
          `${mean(some.map((r) => r.psnr)).toFixed(2)} |`)
      }
  }
}

// Holes and strays of every character's default clip at stored views, on stored frames and half-way between two. Each
// view is baked by itself, so that twenty tell what the whole grid would.
if (table === 'tears') {
  const spec = tiny ? 'polypostor:views=sphere-8x2,frames=4' : 'polypostor:views=sphere-5x4'
  const stored = tiny ? [0] : [0, 3, 6, 8]
  const seen = ['--height-px', tiny ? '60' : '60,120,240', '--elevation-deg', tiny ? '0' : '0,30',
    '--azimuth-deg', tiny ? '0' : [0, 1, 2, 3, 4].map((k) => k * 72).join(',')]
  const cell = (values) => `${mean(values).toFixed(2)} (${Math.max(...values).toFixed(1)})`
  console.log('| character | moments | holes ‰ | strays ‰ | IoU mean | worst | SSIM |\n|---|---|---|---|---|---|---|')
  for (const file of ['mannequin', ...files]) {
    const clip = run('inspect', file).clips.find((c) => c.default)
    const at = (frame) => (clip.start + frame / (tiny ? 4 : 10) * clip.cycle_seconds).toFixed(5)
    for (const [name, frames] of [['stored', stored], ['half-way', stored.map((f) => f + 0.5)]]) {
      const { rows } = run('quality', '--character', file, '--representation', spec, ...seen, '--time', frames.map(at).join(','))
      const iou = rows.map((r) => r.silhouette_iou)
      console.log(`| ${basename(file, '.glb')} | ${name} | ${cell(rows.map((r) => r.holes))} | ` +
        `${cell(rows.map((r) => r.strays))} | ${mean(iou).toFixed(4)} | ${Math.min(...iou).toFixed(4)} | ` +
        `${mean(rows.map((r) => r.ssim)).toFixed(4)} |`)
    }
  }
}

if (table === 'speed') {
  const crowd = ['--agents', tiny ? '12' : '1000', '--occupancy', '0.15', '--size', tiny ? '160x120' : '640x480']
  const times = (ratio, interval) => `${ratio.toFixed(1)} | ${interval.map((v) => v.toFixed(1)).join(' to ')}`
  console.log('| times as fast (process CPU) | as the mesh | 95 % | as its level of 500 triangles | 95 % |\n|---|---|---|---|---|')
  for (const spec of ['polypostor', 'polypostor:key=two_keys', 'flat'].map(small)) {
    const r = run('ratio', '--of', spec, '--to', 'mesh', ...crowd)
    console.log(`| ${spec} | ${times(r.cpu_ratio, r.interval)} | ${times(r.to_500_triangles, r.to_500_triangles_interval)} |`)
  }
}

if (table === 'bake') {
  console.log('| bake | seconds |\n|---|---|')
  for (const key of ['first', 'most_visible', 'two_keys', 'enough'].slice(tiny ? 3 : 0)) {
    const spec = small(`polypostor:key=${key}`)
    console.log(`| ${spec} | ${run('bake', '--representation', spec, '--no-cache').bake_seconds.toFixed(1)} |`)
  }
}

if (table === 'flicker') {
  const specs = ['polypostor', 'flat'].map(small)
  const { flicker, representations } = run('quality', '--flicker', ...specs.flatMap((s) => ['--representation', s]), ...views, '--time',
    moments(20).join(','))
  console.log('| twice the stored rate | pixels | flicker, mean | worst view |\n|---|---|---|---|')
  for (const spec of representations)
    for (const height of [120, 60]) {
      const scores = flicker.filter((r) => r.representation === spec && r.height_px === height).map((r) => r.flicker)
      console.log(`| ${spec} | ${height} | ${mean(scores).toFixed(2)} | ${Math.max(...scores).toFixed(2)} |`)
    }
}
