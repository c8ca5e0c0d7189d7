// Prints the table of frames between of renderers/flat/README.md as Markdown: what flat impostors show half-way between two
// of their stored frames and anywhere in the cycle, at stored views, their bytes and their speed as a ratio to the mesh's.
// Usage: node tools/flat_between.mjs DRIVER [--no-speed] [CHARACTER.glb ...] | DRIVER --tiny
// (about ten minutes for the mannequin, mostly bakes and the ratios; --tiny: few views and frames and no ratio, to see that it runs)
import { basename } from 'node:path'
import { asks } from './driver.mjs'

const [driver, ...rest] = process.argv.slice(2)
const tiny = rest[0] === '--tiny'
if (!driver || (tiny && rest.length > 1) || rest.some((r) => r.startsWith('-') && r !== '--tiny' && r !== '--no-speed')) {
  console.error('usage: flat_between.mjs DRIVER [--no-speed] [CHARACTER.glb ...] | DRIVER --tiny')
  process.exit(2)
}
const speed = !tiny && !rest.includes('--no-speed')
const ask = asks(driver)
const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length
// How it is drawn, and how many frames it stores.
const kinds = tiny ? [['views=sphere-8x2,texels=32,', 4]]
  : [['', 10], ['frames_between=blend,', 10], ['frames_between=move,', 10], ['frames_between=move_blend,', 10],
     ['', 12], ['', 20], ['parallax=3,', 10], ['frames_between=move,parallax=3,', 10]]
const heights = tiny ? [60] : [60, 120]
// Stored views of sphere-17x8.
const views = ['--height-px', heights.join(','), '--azimuth-deg', (tiny ? [0] : [0, 4, 8, 13].map((k) => k * 360 / 17)).join(','),
  '--elevation-deg', (tiny ? [0] : [0, 90 / 7]).join(',')]

for (const character of ['mannequin', ...rest.filter((r) => !r.startsWith('-'))]) {
  const clip = ask('inspect', character).clips.find((c) => c.default)
  const at = (phase) => (clip.start + phase * clip.cycle_seconds).toFixed(6)
  console.log(`${basename(character, '.glb')}:\n`)
  console.log('| representation | MiB | half-way: px | IoU | SSIM | holes ‰ | strays ‰ | anywhere: IoU | SSIM | times the mesh |')
  console.log('|---|---|---|---|---|---|---|---|---|---|')
  for (const [options, frames] of kinds) {
    const spec = `flat:${options}frames=${frames}`
    const some = (times) => ask('quality', '--character', character, '--clip', clip.name, '--representation', spec,
      '--bake-budget', '2048', ...views, '--time', times.join(','))
    // Five steps of the cycle; and nine moments that no number of frames favours.
    const half = some(Array.from({ length: tiny ? 1 : 5 }, (_, k) => at((Math.floor(k * frames / 5) + 0.5) / frames))).rows
    const any = some(Array.from({ length: tiny ? 1 : 9 }, (_, k) => at((0.03 + k * 0.6180339887) % 1))).rows
    const bytes = ask('bake', '--character', character, '--clip', clip.name, '--representation', spec, '--bake-budget', '2048').gpu_bytes
    const ratio = speed && ask('ratio', '--of', spec, '--to', 'mesh', '--character', character, '--agents', '1000',
      '--occupancy', '0.15', '--size', '640x480', '--bake-budget', '2048')
    for (const height of heights) {
      const of = (rows, key) => rows.filter((r) => r.height_px === height).map((r) => r[key])
      const first = height === heights[0]
      const worst = (key) => `${mean(of(half, key)).toFixed(2)} (${Math.max(...of(half, key)).toFixed(1)})`
      console.log(`| ${first ? spec : ''} | ${first ? (bytes / (1 << 20)).toFixed(1) : ''} | ${height} ` +
        `| ${mean(of(half, 'silhouette_iou')).toFixed(3)} | ${mean(of(half, 'ssim')).toFixed(3)} | ${worst('holes')} | ${worst('strays')} ` +
        `| ${mean(of(any, 'silhouette_iou')).toFixed(3)} | ${mean(of(any, 'ssim')).toFixed(3)} ` +
        `| ${first && ratio ? `${ratio.cpu_ratio.toFixed(1)} (${ratio.interval.map((v) => v.toFixed(1)).join(' .. ')})` : first ? '-' : ''} |`)
    }
  }
  console.log('')
}
