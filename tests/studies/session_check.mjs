// The page's session against a network that misbehaves, without a browser: node session_check.mjs PAGE_FOLDER. What
// `fetch` answers is said beforehand; status 0 where every answer reached the server as often as it should.
import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { join } from 'node:path'
import vm from 'node:vm'

// The page's scripts with a browser's storage, and time that does not pass.
function page(respond, files = ['text.js', 'session.js']) {
  const storage = () => {
    const kept = new Map()
    return { getItem: (key) => kept.get(key) ?? null, setItem: (key, value) => kept.set(key, value), removeItem: (key) => kept.delete(key) }
  }
  const asked = []
  const world = vm.createContext({
    URLSearchParams, TextEncoder, Blob, URL, crypto: globalThis.crypto, setTimeout: (wake) => setImmediate(wake), clearTimeout: () => {},
    history: { replaceState: () => {} }, jsPsychModule: { ParameterType: {} },
    document: { getElementById: () => ({}), createElement: () => ({ canPlayType: () => '' }) },
    fetch: async (path, options) => {
      asked.push({ path, body: options?.body })
      assert.ok(asked.length < 50, 'asks for ever')
      return respond(path, asked.length)
    }
  })
  world.window = world
  Object.assign(world, { location: { search: '', pathname: '/' }, localStorage: storage(), sessionStorage: storage() })
  for (const file of files) vm.runInContext(readFileSync(join(process.argv[2], file), 'utf8'), world)
  return { Study: world.Study ?? vm.runInContext('Study', world), asked, world }
}
const answers = (status) => ({ status, ok: status === 200, json: async () => ({}) })
function session(statuses) {
  const { Study, asked } = page((path, number) => answers(statuses[number - 1] ?? 200))
  const made = new Study.Session('a'.repeat(64))
  made.served = true
  return { made, asked }
}

// What a proxy says is no refusal by the server: the answer stays, and is sent again.
for (const status of [403, 404, 408, 421, 429, 502]) {
  const { made, asked } = session([status, status])
  made.add({ item: 't001' })
  await made.send()
  assert.equal(asked.length, 3, `after ${status} twice`)
  assert.equal(made.state.outbox.length, 0)
}
// Where a program drives the browser, every record says that its observer is simulated.
for (const [webdriver, mark] of [[true, 'simulated'], [false, undefined], [undefined, undefined]]) {
  const { Study, asked, world } = page(() => answers(200))
  world.navigator = { webdriver }
  const made = new Study.Session('a'.repeat(64))
  made.add({ item: 't001', answer: 'upper' })
  made.add({ item: 'comments', kind: 'page' })
  assert.deepEqual([...made.rows()].map((row) => row.observers), [mark, mark])
  made.served = true
  made.add({ item: 't002' })
  await made.send()
  assert.equal(JSON.parse(asked[0].body).observers, mark)
}
// What the server refuses it would refuse again.
for (const status of [400, 409, 413]) {
  const { made, asked } = session([status])
  made.add({ item: 't001' })
  await made.send()
  assert.equal(asked.length, 1, `after ${status}`)
}
// The end, where another window has taken over meanwhile.
{
  const { made, asked } = session(Array(60).fill(401))
  let told = 0
  made.whenTaken = () => { ++told }
  await made.finish()
  assert.equal(asked.length, 1)
  assert.equal(told, 1)
  assert.equal(made.state.finished, false)
}
// The end, where the server has not got all answers: it is said, and a reload asks for them.
{
  const { made, asked } = session([409])
  await assert.rejects(made.finish(), /has not got all your answers/)
  assert.equal(asked.length, 1)
  assert.equal(made.state.finished, false)
}
// What was shown and answered comes back from the server; of what it has not got yet this browser knows better.
{
  const { Study } = page((path) => (path === 'api/start'
    ? { status: 200, ok: true, json: async () => ({ token: 'x', list: '1', state: 'started', items: ['t001'], given: { t001: { stimulus: 's007', answer: 'upper' } } }) }
    : answers(502)))
  const made = new Study.Session('a'.repeat(64))
  assert.equal(made.given('t001'), undefined)
  made.served = true
  made.send = async () => {}
  made.add({ item: 't002', stimulus: 's003', answer: 'lower' })
  made.add({ item: 'screen-1' })
  await made.start(['1'])
  assert.equal(made.given('t001').stimulus, 's007')
  assert.equal(made.given('t002').answer, 'lower')
  assert.equal(made.given('screen-1'), undefined)
  assert.equal(JSON.parse(JSON.stringify(new Study.Session('a'.repeat(64)).given('t002'))).stimulus, 's003', 'after a reload')
}
// How often a trial was begun: counted here, told to the server before the answer, and what the server knows counts where this
// browser's storage knows less.
{
  const { Study, asked } = page((path) => (path === 'api/start'
    ? { status: 200, ok: true, json: async () => ({ token: 'x', list: '1', state: 'started', items: [], given: {}, begun: { t001: 2, t002: 1 } }) }
    : answers(200)))
  const made = new Study.Session('a'.repeat(64))
  assert.equal(made.begin('t002'), 0)
  assert.equal(made.begin('t002'), 1)
  assert.equal(asked.length, 0, 'nothing is sent where no server of ours is')
  made.served = true
  await made.start(['1'])
  assert.equal(made.begin('t001'), 2, 'in another browser')
  assert.equal(made.begin('t002'), 2, 'this one knows better')
  assert.equal(made.begin('t003'), 0)
  made.add({ item: 't003', kind: 'main', answer: 'upper' })
  await made.send()
  const sent = asked.filter(({ path }) => path === 'api/answer').map(({ body }) => JSON.parse(body))
  assert.deepEqual(sent.map(({ item, kind, begun }) => [item, kind, begun]),
    [['t001', 'begin', 3], ['t002', 'begin', 3], ['t003', 'begin', 1], ['t003', 'main', undefined]])
}
// What waits to be sent of a trial that was only begun does not make it an answered one.
{
  const { Study } = page((path) => (path === 'api/start'
    ? { status: 200, ok: true, json: async () => ({ token: 'x', list: '1', state: 'started', items: [], given: {} }) }
    : answers(502)))
  const made = new Study.Session('a'.repeat(64))
  made.served = true
  made.send = async () => {}
  made.begin('t001')
  await made.start(['1'])
  assert.equal(made.has('t001'), false)
}
// One pixel of a clip is one of the screen where the window has room for that, with what belongs to it below or beside.
{
  const { Study, world } = page(() => answers(200), ['text.js', 'trial.js'])
  world.document.getElementById = () => ({ offsetHeight: 53 })
  const fit = (width, height, ratio, ...clip) => {
    Object.assign(world, { innerWidth: width, innerHeight: height, devicePixelRatio: ratio })
    world.document.documentElement = { clientWidth: width }
    const { scale, beside } = Study.fit(...clip)
    return [Math.round(1000 * scale), beside]
  }
  assert.deepEqual(fit(1280, 800, 1, 320, 496), [1000, false])
  assert.deepEqual(fit(1920, 1080, 1, 640, 976), [1000, true], 'a full screen of the most common size')
  assert.deepEqual(fit(1920, 1080, 2, 640, 976), [1000, false], 'two pixels of the screen a CSS pixel')
  assert.deepEqual(fit(1280, 800, 1, 640, 976), [745, true])
  assert.deepEqual(fit(390, 640, 1, 320, 496), [907, false])
  assert.deepEqual(fit(200, 100, 1, 640, 976), [123, false], 'never nothing')
}
// A clip is asked for under its contents, and one that was compressed on its way is whole.
{
  const sent = new Uint8Array(10)
  const { Study, asked } = page(() => ({
    status: 200, ok: true, body: new Blob([sent]).stream(),
    headers: { get: (name) => ({ 'Content-Length': '3', 'Content-Encoding': 'gzip' })[name] ?? null }
  }), ['text.js', 'clips.js'])
  const file = { src: 'clips/s001.mp4', type: 'video/mp4', sha256: 'b8c2'.repeat(16) }
  const clips = new Study.Clips({ stimuli: { s001: { files: [file] } } })
  clips.type = file.type
  // The contents are checked too, and are not these.
  await assert.rejects(clips.load(['s001'], () => {}), /arrived damaged/)
  assert.equal(asked[0].path, 'clips/s001.mp4?b8c2b8c2b8c2b8c2')
}
// A clip that is broken says so twice, and is loaded again once.
{
  const { Study } = page(() => answers(200), ['text.js', 'session.js', 'trial.js'])
  let loads = 0
  const trial = Object.assign(Object.create(Study.TrialPlugin.prototype), { video: { load: () => { ++loads } }, play: () => {} })
  for (let failures = 1; failures <= 2; ++failures) {
    trial.failed()
    trial.failed()
    await new Promise((wake) => setTimeout(wake, 20))
    assert.equal(loads, failures)
  }
}
// A page that is hidden just as the clip ends, in whatever order the two are told: the showing begins anew when the page is
// seen again, and then opens the answers.
for (const order of [['hide', 'end', 'show'], ['end', 'hide', 'show'], ['hide', 'show', 'end'], ['hide while told', 'end', 'show']]) {
  const { Study, world } = page(() => answers(200), ['text.js', 'session.js', 'trial.js'])
  const listeners = {}
  let opened = 0
  let plays = 0
  Object.assign(world, { performance, requestAnimationFrame: () => {} })
  Object.assign(world.document, { hidden: false, addEventListener: (name, then) => { listeners[name] = then } })
  const video = { ended: false, paused: false, play: async () => { ++plays; video.ended = false } }
  const trial = Object.assign(Object.create(Study.TrialPlugin.prototype), {
    video, shown: { interrupted: 0 }, frames: { total: 0, dropped: 0 }, firstEnd: null, parameters: { answers: [] },
    jsPsych: { pluginAPI: { getKeyboardResponse: () => ({}) } }, open: (yes) => { opened += yes ? 1 : 0 }
  })
  trial.watch()
  trial.play()
  video.ended = true
  for (const step of order) {
    if (step === 'end') trial.ended()
    if (step.startsWith('hide')) world.document.hidden = true
    if (step === 'show') world.document.hidden = false
    if (step === 'hide' || step === 'show') listeners.visibilitychange()
  }
  if (order[0] === 'end') {
    assert.deepEqual([opened, plays, trial.shown.interrupted], [1, 1, 0], 'its end was seen')
    continue
  }
  assert.deepEqual([opened, plays, trial.shown.interrupted], [0, 2, 1], order.join(', '))
  video.ended = true
  trial.ended()
  assert.equal(opened, 1, order.join(', '))
}
