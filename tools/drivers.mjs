// What the OpenGL drivers of this machine agree on: the stability battery and a picture of every representation, under
// each of them. Markdown on stdout: docs/drivers.md.
//
//   node tools/drivers.mjs DRIVER FOLDER [--device D] [--small] [--tiny]
//
// Drivers: llvmpipe with vectors of 256 and of 128 bits, Mesa's zink over lavapipe, and with --device also that one (a GPU:
// `crowdbench info` lists them). One that is not here is left out, and the page says so. --small: the battery's small form;
// --tiny: one case and one representation of it, to see that it runs.
import { spawnSync } from 'node:child_process'
import { mkdirSync } from 'node:fs'
import { join } from 'node:path'
import { parseArgs } from 'node:util'

const usage = 'usage: drivers.mjs DRIVER FOLDER [--device D] [--small] [--tiny]'
let options
let positionals
try {
  ({ values: options, positionals } = parseArgs({
    allowPositionals: true,
    options: { device: { type: 'string' }, small: { type: 'boolean' }, tiny: { type: 'boolean' } }
  }))
} catch (error) {
  console.error(`drivers: ${error.message}; ${usage}`)
  process.exit(2)
}
const [driver, folder] = positionals
if (positionals.length !== 2) {
  console.error(usage)
  process.exit(2)
}
mkdirSync(folder, { recursive: true })

// As JSON. Status 1, a case that does not hold, is an answer.
function ask(under, ...args) {
  const run = spawnSync(driver, [...args, '--json', ...under.args], {
    maxBuffer: 1 << 28, env: { ...process.env, ...under.env }, stdio: ['ignore', 'pipe', 'pipe']
  })
  if (run.error || run.status > 1 || run.status === null) {
    console.error(`${String(run.stderr ?? run.error).trim().split('\n').pop()}\nfailed (${run.status}): ${[driver, ...args].join(' ')}`)
    process.exit(2)
  }
  return JSON.parse(run.stdout)
}

const software = ['--device', 'software']
const all = [
  { env: {}, args: software, is: (r) => r.includes('llvmpipe') },
  { env: { LP_NATIVE_VECTOR_WIDTH: '128' }, args: software, is: (r) => r.includes('128 bits') },
  { env: { MESA_LOADER_DRIVER_OVERRIDE: 'zink', LIBGL_ALWAYS_SOFTWARE: '1' }, args: [], is: (r) => r.includes('zink') }
]
if (options.device) all.push({ env: {}, args: ['--device', options.device], is: () => true })
const drivers = []
let absent = 0
for (const each of all) {
  const { renderer } = ask(each, 'info')
  if (each.is(renderer)) drivers.push({ ...each, renderer })
  else ++absent
}

// ---- the battery

const battery = options.tiny ? ['--small', '--representation', 'mesh', '--case', 'time_wrap'] : options.small ? ['--small'] : []
for (const each of drivers) {
  console.error(`drivers: the battery on ${each.renderer}`)
  each.cases = ask(each, 'stability', ...battery).cases
}
// Of a case's rows the one that is nearest to its bound, or exceeds it most.
const share = (row) => (row.error ? Infinity : row.bound > 0 ? row.measured / row.bound : row.measured > 0 ? Infinity : 0)
function worst(cases, name) {
  return cases.filter((row) => row.case === name).reduce((a, b) => (a && share(a) >= share(b) ? a : b), undefined)
}
const number = (x) => (x === null ? '-' : Number(x.toPrecision(3)).toString())
function cell(row) {
  if (!row) return 'not asked'
  if (row.error) return `**not measured**: ${row.error}`
  return `${number(row.measured)}${row.representation && row.measured > 0 ? ` (${row.representation})` : ''}${row.pass ? '' : ' **fails**'}`
}

console.log('# What the drivers agree on\n\nMade by `node tools/drivers.mjs build/release/bin/crowdbench FOLDER`' +
  `${options.small ? ' with --small' : ''}. ${absent === 0 ? '' : `${absent} of the drivers that it knows were not on this machine.`}\n`)
console.log('## The battery\n\nOf every case the representation that comes nearest to its bound, or exceeds it most, under each driver.\n')
console.log(`| case | bound | unit |${drivers.map((d) => ` ${d.renderer} |`).join('')}\n|---|--:|---|${drivers.map(() => '---|').join('')}`)
for (const name of new Set(drivers[0].cases.map((row) => row.case))) {
  const rows = drivers.map((d) => worst(d.cases, name))
  const first = rows.find((row) => row)
  console.log(`| \`${name}\` | ${number(first.bound)} | ${first.unit} |${rows.map((row) => ` ${cell(row)} |`).join('')}`)
}

// ---- a picture of each

const names = options.tiny ? ['mesh'] : ask(drivers[0], 'info', '--representations').filter((r) => r.stands_alone).map((r) => r.name)
console.log('\n## Pictures\n\nTwelve agents, 320 x 240, against the first driver: the largest and the mean difference, code values.\n')
console.log(`| representation |${drivers.slice(1).map((d) => ` ${d.renderer} |`).join('')}\n|---|${drivers.slice(1).map(() => '---|').join('')}`)
const file = (name, d) => join(folder, `${name}-${d}.png`)
for (const name of names) {
  drivers.forEach((each, d) => {
    ask(each, 'render', '--representation', name, '--agents', '12', '--size', '320x240', '--out', file(name, d))
  })
  const cells = drivers.slice(1).map((each, d) => {
    const { worst: most, scores } = ask({ env: {}, args: [] }, 'compare', file(name, 0), file(name, d + 1), '--scores', 'mae')
    return ` ${most.difference}, ${number(scores.mae)} |`
  })
  console.log(`| ${name} |${cells.join('')}`)
}
