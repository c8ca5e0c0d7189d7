// Random faults under `sweep`, `bake`, `pair` and `bench`: killed, stopped, a full disk, little memory, no folder, damaged bakes, two
// processes at once on one result and one cache, a clock that jumps. After each the same command runs undisturbed over what was
// left, and must leave what it leaves in a clean folder: nothing lost, nothing half-written read, no file too many. What a
// disturbed run says of its end must be one line, and its status one that the guide knows.
//
//   node tools/random_faults.mjs DRIVER FOLDER [FAULTS [SEED]]    1,000 faults by seed 1 where it is not said
//
// The seed chooses commands, faults and their sizes; at which instruction a kill falls, nobody chooses. A fault whose tool is
// missing (faketime) is left out and named. Status 0: all held; 1: some did not, and how is said.
import { execFileSync, spawn, spawnSync } from 'node:child_process'
import { createHash } from 'node:crypto'
import { copyFileSync, existsSync, mkdirSync, readdirSync, readFileSync, rmSync, statSync, truncateSync, writeFileSync } from 'node:fs'
import { join, resolve } from 'node:path'
import { held_of_sweep, small_plan } from './small_sweep.mjs'

const [program, folder, faults = '1000', seed = '1'] = process.argv.slice(2)
if (!program || !folder || !(Number(faults) >= 1) || !(Number(seed) >= 0)) {
  console.error('usage: random_faults.mjs DRIVER FOLDER [FAULTS [SEED]]')
  process.exit(2)
}
const driver = resolve(program)
const work = resolve(folder)
rmSync(work, { recursive: true, force: true })
mkdirSync(work, { recursive: true })
process.env.CROWDBENCH_DEVICE = 'software'
process.env.CROWDBENCH_CACHE_DIR = join(work, 'cache')
process.env.MESA_SHADER_CACHE_DISABLE = 'true'

// Seeded: mulberry32.
let state = Number(seed) >>> 0
function random() {
  state = (state + 0x6d2b79f5) >>> 0
  let t = Math.imul(state ^ (state >>> 15), state | 1)
  t ^= t + Math.imul(t ^ (t >>> 7), t | 61)
  return ((t ^ (t >>> 14)) >>> 0) / 4294967296
}
const among = (list) => list[Math.floor(random() * list.length)]
const sha = (file) => createHash('sha256').update(readFileSync(file)).digest('hex')
const asks = (...args) => JSON.parse(execFileSync(driver, args, { cwd: work, maxBuffer: 1 << 28, stdio: ['ignore', 'pipe', 'pipe'] }))

writeFileSync(join(work, 'small.toml'), small_plan)
const impostor = 'flat:views=sphere-8x2,frames=4,texels=64'
const figure = ['--character', 'mannequin:triangles=500']
const bench = ['bench', '--representation', `mesh:triangles=250,${impostor}`, ...figure, '--agents', '1,2', '--occupancy', '0.15', '--rounds', '10',
  '--time-limit', '0.05', '--size', '64x48', '--no-floors', '--out', 'bench.sqlite', '--json']
// What each runs, which files it leaves, and what these hold that no clock decides.
const commands = {
  sweep: {
    args: ['sweep', 'small.toml', '--out', 'sweep.sqlite', '--json'],
    files: /^sweep\.sqlite/,
    held: () => held_of_sweep(asks('sweep', 'small.toml', '--out', 'sweep.sqlite', '--json'))
  },
  bake: {
    args: ['bake', '--representation', impostor, ...figure, '--json'],
    files: /^picture\.png$/,
    held: () => {
      execFileSync(driver, ['render', '--representation', impostor, ...figure, '--agents', '3', '--size', '64x48', '--out', 'picture.png'],
        { cwd: work, stdio: 'pipe' })
      const baked = asks('bake', '--representation', impostor, ...figure, '--json')
      return `${sha(join(work, 'picture.png'))} cached ${baked.cached} ${baked.disk_bytes} bytes`
    }
  },
  pair: {
    args: ['pair', '--a', 'mesh', '--b', impostor, ...figure, '--agents', '2', '--frames', '2', '--size', '64x48', '--out', 'pair.mp4'],
    files: /^pair\./,
    held: () => `${sha(join(work, 'pair.mp4'))} ${sha(join(work, 'pair.json'))}`
  },
  bench: {
    args: bench,
    files: /^bench\.sqlite/,
    held: () => {
      const rows = asks(...bench)
      return rows.measurements.map((m) => `${m.representation} ${m.agents} ${m.state ?? ''} ${m.triangles ?? ''}`).sort().join('\n')
    }
  }
}
const left = (command) => readdirSync(work).filter((name) => commands[command].files.test(name)).sort()
const forget = (command) => left(command).forEach((name) => rmSync(join(work, name), { recursive: true, force: true }))
const bakes = () => {
  const at = join(work, 'cache', 'bakes')
  return existsSync(at) ? readdirSync(at).map((name) => join(at, name)) : []
}

// A run to its end: status or signal, and what it said. before: shell words before the program. end: {after_ms, signal}.
function run(args, before = '', end = null) {
  const words = [driver, ...args].map((word) => `'${word}'`).join(' ')
  const child = spawn('bash', ['-c', `${before.startsWith('exec') ? before : before + ' exec'} ${words}`], { cwd: work, stdio: ['ignore', 'ignore', 'pipe'] })
  let said = ''
  child.stderr.on('data', (text) => (said += text))
  const timer = end ? setTimeout(() => child.kill(end.signal), end.after_ms) : null
  return new Promise((done) => child.on('close', (status, signal) => {
    clearTimeout(timer)
    done({ status, signal, said })
  }))
}
// The lines that tell of an end; warnings and progress are others.
const ends = (said) => said.split('\n').filter((line) => /^crowdbench: /.test(line) && !/^crowdbench: (warning|drawing on)/.test(line))

const have = (tool) => spawnSync('bash', ['-c', `command -v ${tool}`]).status === 0
const kFaults = {
  kill: async (c) => [await run(c.args, '', { after_ms: random() * c.ms, signal: 'SIGKILL' })],
  term: async (c) => [await run(c.args, '', { after_ms: random() * c.ms, signal: 'SIGTERM' })],
  interrupt: async (c) => [await run(c.args, '', { after_ms: random() * c.ms, signal: 'SIGINT' })],
  // Blocks of 1,024 bytes; what a full disk tells is what this limit tells.
  'full disk': async (c) => [await run(c.args, `trap '' XFSZ; ulimit -f ${Math.floor(Math.exp(random() * 8.5))};`)],
  'little memory': async (c) => [await run(c.args, `ulimit -v ${Math.floor(60e3 * Math.exp(random() * 3.5))};`)],
  'no folder': async (c) => {
    if (!c.args.includes('--out')) return [await run(c.args, 'CROWDBENCH_CACHE_DIR=/proc/none')]
    writeFileSync(join(work, 'file'), 'x')
    const args = [...c.args]
    const at = args.indexOf('--out') + 1
    args[at] = `file/${args[at]}`
    const ended = await run(args)
    if (ended.status !== 2) ended.wrong = `status ${ended.status} where the folder is a file`
    return [ended]
  },
  'damaged bake': async (c) => {
    for (const bake of bakes()) {
      const size = statSync(bake).size
      const how = among(['cut', 'flipped', 'other', 'empty', 'version'])
      if (how === 'cut') truncateSync(bake, Math.floor(random() * size))
      if (how === 'empty') truncateSync(bake, 0)
      if (how === 'other') copyFileSync(join(work, 'small.toml'), bake)
      if (how === 'flipped' || how === 'version') {
        const bytes = readFileSync(bake)
        for (let i = 0; i < 4; ++i) bytes[Math.floor(random() * (how === 'version' ? Math.min(64, size) : size))] ^= 1 + Math.floor(random() * 255)
        writeFileSync(bake, bytes)
      }
    }
    const ended = await run(c.args)
    if (ended.status !== 0) ended.wrong = `status ${ended.status} with a damaged bake: ${ended.said}`
    return [ended]
  },
  'two at once': async (c) => Promise.all([run(c.args), new Promise((go) => setTimeout(go, random() * 0.5 * c.ms)).then(() => run(c.args))]),
  ...(have('faketime') && { 'clock that jumps': async (c) => [await run(c.args, `exec faketime -f '${among(['-10y', '+3y', '-1d x50', '+0 x0.01'])}' `)] })
}
const kStatuses = [0, 1, 2, 3, 75, 130, 143]

// What is wrong with how a disturbed run ended; empty: nothing.
function wrong_end(fault, ended) {
  if (ended.wrong) return ended.wrong
  const killed = ended.signal !== null
  // A driver that gets no memory may end the process itself: that is said too.
  if (fault === 'little memory' && ['SIGSEGV', 'SIGABRT', 'SIGBUS'].includes(ended.signal))
    return ends(ended.said).length === 1 ? '' : `ended by ${ended.signal} without its one line: ${ended.said.slice(-400)}`
  if (killed && !(ended.signal === 'SIGKILL' && fault === 'kill') && !(['term', 'interrupt'].includes(fault) && ['SIGTERM', 'SIGINT'].includes(ended.signal)))
    return `ended by ${ended.signal}: ${ended.said.slice(-400)}`
  if (!killed && !kStatuses.includes(ended.status)) return `status ${ended.status}: ${ended.said.slice(-400)}`
  const lines = ends(ended.said)
  if (!killed && ended.status === 2 && lines.length !== 1) return `${lines.length} lines of its end: ${ended.said.slice(-400)}`
  return ''
}

const wanted = {}
for (const [name, command] of Object.entries(commands)) {
  const begun = Date.now()
  execFileSync(driver, command.args, { cwd: work, maxBuffer: 1 << 28, stdio: ['ignore', 'ignore', 'pipe'] })
  command.ms = Date.now() - begun
  wanted[name] = command.held()
  command.left = left(name).join(' ')
  forget(name)
}
if (!kFaults['clock that jumps']) console.log('left out: a clock that jumps (package faketime)')

const counts = {}
let wrongs = 0
let said_at = Date.now()
for (let i = 1; i <= Number(faults); ++i) {
  const name = among(Object.keys(commands))
  const fault = among(Object.keys(kFaults))
  const command = commands[name]
  if (random() < 0.4) rmSync(join(work, 'cache'), { recursive: true, force: true })
  const ends_seen = await kFaults[fault](command)
  let wrong = ends_seen.map((ended) => wrong_end(fault, ended)).find((text) => text) ?? ''
  if (!wrong) {
    const again = await run(command.args)
    if (again.status !== 0) wrong = `run again, status ${again.status ?? again.signal}: ${again.said.slice(-400)}`
    else {
      const held = command.held()
      if (held !== wanted[name]) wrong = `run again, another result: ${held.slice(0, 300)} for ${wanted[name].slice(0, 300)}`
      else if (left(name).join(' ') !== command.left) wrong = `files left: ${left(name).join(' ')} for ${command.left}`
    }
  }
  counts[fault] = (counts[fault] ?? 0) + 1
  if (wrong) {
    ++wrongs
    console.log(`fault ${i}, ${fault} under ${name}: ${wrong}`)
  }
  if (wrong || random() < 0.5) forget(name)
  if (Date.now() - said_at > 10000) {
    said_at = Date.now()
    console.error(`${i} of ${faults} faults, ${wrongs} wrong`)
  }
}
for (const [fault, count] of Object.entries(counts)) console.log(`${fault}: ${count}`)
console.log(`${faults} faults by seed ${seed}, ${wrongs} of them with another end than they should`)
process.exit(wrongs === 0 ? 0 : 1)
