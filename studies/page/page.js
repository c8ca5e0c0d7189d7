// Page: the study from consent to debrief, as a jsPsych timeline made of what is still to be answered.
(async function () {
  'use strict'

  const stage = document.getElementById('stage')
  const page = (item, data) => ({ item, kind: 'page', ...data })
  let session
  let trials
  let adaptive  // where trials are chosen by the answers so far
  let leaving = false

  // ---- what every screen shares

  function fatal(title, text) {
    document.getElementById('bar').hidden = true
    stage.innerHTML = `<div class="text"><h1>${Study.escape(title)}</h1><p>${Study.escape(text)}</p></div>`
    document.body.dataset.state = 'stopped'
    stage.focus()
  }
  // A screen of text with buttons under it. on: what becomes of the button's number; it may wait.
  const screen = (html, choices, more) => ({
    type: jsPsychHtmlButtonResponse, stimulus: `<div class="text">${html}</div>`, choices,
    button_html: (choice) => `<button type="button" class="jspsych-btn">${choice}</button>`, ...more
  })
  const forget = (data) => { delete data.stimulus }  // the text is in the study's folder already

  async function run(timeline) {
    if (timeline.length === 0) return
    stage.innerHTML = ''
    const jsPsych = initJsPsych({
      display_element: stage,
      on_trial_start: () => window.scrollTo(0, 0),
      on_data_update: (row) => {
        if (!row.item || leaving) return
        if (row.trial_type === 'html-button-response') forget(row)
        session.add(row)
        where()
      }
    })
    Study.jsPsych = jsPsych
    jsPsych.data.addProperties({ study: trials.study, participant: session.participant, list: session.state.list })
    await jsPsych.run(timeline)
  }
  // Where a screen has a heading, it is what a screen reader begins with.
  new MutationObserver(() => {
    const heading = stage.querySelector('h1')
    if (!heading || heading.dataset.met) return
    heading.dataset.met = 'yes'
    heading.tabIndex = -1
    if (!stage.contains(document.activeElement) || document.activeElement === document.body) heading.focus()
  }).observe(stage, { childList: true, subtree: true })

  const list = () => trials.lists.find((each) => each.id === session.state.list)
  function where(shown) {
    const all = list().trials
    const done = all.filter((each) => session.has(each.trial)).length
    const trial = `${shown?.kind === 'training' ? 'Practice, trial' : 'Trial'} ${done + 1} of ${all.length}`
    const text = shown || (done > 0 && done < all.length) ? trial : done === 0 ? 'Before the trials' : 'After the trials'
    document.getElementById('where').textContent = text
    const progress = document.getElementById('progress')
    progress.max = all.length
    progress.value = done
  }

  // ---- leaving

  function ready_to_leave() {
    const dialog = document.getElementById('leaving')
    document.getElementById('leave').addEventListener('click', () => dialog.showModal())
    dialog.addEventListener('click', async (event) => {
      if (event.target.value === 'stay') dialog.close()
      if (event.target.value !== 'withdraw' || leaving) return
      // Open until it is done: nothing can be answered meanwhile, which would not be sent any more.
      const buttons = dialog.querySelectorAll('button')
      for (const button of buttons) button.disabled = true
      await withdraw()
      for (const button of buttons) button.disabled = false
      dialog.close()
    })
    dialog.addEventListener('cancel', (event) => { if (leaving) event.preventDefault() })
  }
  async function withdraw() {
    leaving = true
    try {
      await session.withdraw()
    } catch {
      leaving = false
      session.taken = false
      Study.notice('Your answers could not be deleted: the server does not answer. Please try again.')
      return
    }
    if (document.fullscreenElement) document.exitFullscreen().catch(() => {})
    Study.jsPsych?.abortExperiment()
    Study.notice('')
    await Study.sleep(0)
    fatal('You have withdrawn', 'Your answers have been deleted. Thank you for your time; you may close this window.')
    document.body.dataset.state = 'withdrawn'
  }

  function taken() {
    leaving = true
    Study.jsPsych?.abortExperiment()
    setTimeout(() => fatal('Continued in another window', 'The study goes on there, or you have withdrawn in it. You may close this one.'))
  }

  // ---- the screens

  const texts = {}
  async function read_texts() {
    for (const name of ['consent', 'instructions', 'debrief']) {
      const value = trials[name] ?? ''
      if (/^[\w-]+\.md$/.test(value)) {
        const response = await fetch(value, { cache: 'no-store' })
        if (!response.ok) throw new Error(`${value} is missing`)
        texts[name] = await response.text()
      } else {
        texts[name] = value
      }
    }
  }

  async function consent() {
    let agreed = false
    await run([screen(Study.markdown(texts.consent), ['I agree', 'I do not agree'], {
      on_finish: (data) => { agreed = data.response === 0 }
    })])
    if (agreed) session.state.consented = true
    return agreed
  }

  // A question of the plan: words, or {"name", "label", "type": "text" | "number" | "choice", "choices"}. All may be left empty.
  function field(question, number) {
    const q = typeof question === 'string' ? { label: question } : question
    const name = Study.escape(q.name ?? `question-${number + 1}`)
    const label = Study.escape(q.label ?? q.name)
    if (q.type !== 'choice')
      return `<p><label for="${name}">${label}</label> <input id="${name}" name="${name}" type="${q.type === 'number' ? 'number' : 'text'}" maxlength="200"></p>`
    const choices = ['', ...q.choices].map((choice) => `<option>${Study.escape(choice)}</option>`)
    return `<p><label for="${name}">${label}</label> <select id="${name}" name="${name}">${choices.join('')}</select></p>`
  }
  const demographics = () => ({
    type: jsPsychSurveyHtmlForm,
    preamble: '<div class="text"><h1>About you</h1><p>You may leave any of this empty.</p></div>',
    html: `<div class="text">${trials.demographics.map(field).join('')}</div>`,
    button_label: 'Continue', data: page('demographics')
  })

  const fullScreen = (again) => screen(
    `<h1>${again ? 'Full screen again' : 'Full screen'}</h1><p>${again ? 'The study left full screen. ' : ''}The clips are
     best judged when nothing else is on the screen. The key <kbd>Esc</kbd> leaves full screen.</p>`,
    ['Full screen', 'Go on without'],
    {
      on_finish: async (data) => {
        Object.assign(data, page(session.next('screen')))
        data.full_screen = data.response === 0 ? await Study.fullScreen() : 'not wanted'
        Study.wantsFullScreen = data.full_screen === 'entered' || data.full_screen === 'already'
        data.window = Study.window.size()
      }
    })
  const small = () => screen(
    `<h1>A small screen</h1><p>The clips are ${trials.width} × ${trials.height} pixels, more than fit here. They will be shown
     smaller, which hides what the study is about. A larger window or another device is better.</p>`,
    ['Go on'])
  const tooSmall = () => Study.fit(trials.width, trials.height).scale < 1

  const instructions = () => screen(
    `${Study.markdown(texts.instructions)}<h2>How to answer</h2><p>After each clip: ${trials.answers.map((a) =>
      `<strong>${Study.escape(a.label)}</strong>${a.key ? ` with the key <kbd>${Study.escape(a.key.toUpperCase())}</kbd>` : ''}`).join(', ')};
     or with the buttons. ${trials.replays > 0 ? `A clip may be shown again ${trials.replays === 1 ? 'once' : trials.replays + ' times'} (<kbd>R</kbd>).` : 'A clip is shown once.'}</p>`,
    ['Start'])

  // What a trial shows: what its list says, or what the answers before it lead to. Until it is answered that stays the
  // same, and a reload finds the same again.
  function shown_by(trial) {
    if (trial.stimulus) return trial.stimulus
    const before = list().trials.filter((each) => each.kind === 'main' && each !== trial).map((each) => session.given(each.trial))
    return adaptive.choose(session.state.list, trial.trial, before.filter(Boolean))
  }
  // The clips of some trials; the first time with the choice of the file type. Of trials that are chosen later, all that may
  // be, as far as there is room.
  function clips_of(some) {
    const named = some.map((each) => each.stimulus).filter(Boolean)
    const chosen = some.some((each) => !each.stimulus) && adaptive.stimuli.length + named.length <= kMostLoaded ? adaptive.stimuli : []
    return [...new Set([...named, ...chosen])]
  }
  const load = (stimuli) => ({
    type: Study.LoadPlugin, stimuli, choose: true,
    on_finish: (data) => {
      if (!session.told) Object.assign(data, page(session.next('browser')), { agent: navigator.userAgent })
      session.told = true
      if (data.clip_type === null) {
        Study.stopped = true
        Study.jsPsych.abortExperiment()
      }
    }
  })

  const kMostLoaded = 24  // clips in memory at once
  function one(trial, used) {
    let restarts = 0
    const data = { item: trial.trial, kind: trial.kind, stimulus: trial.stimulus, block: trial.block }
    return {
      type: Study.TrialPlugin,
      url: () => Study.clips.urls.get(shown_by(trial)),
      question: trials.question, answers: trials.answers, replays: trials.replays, frames: trials.frames,
      width: trials.width, height: trials.height,
      data,
      on_start: () => {
        data.stimulus = shown_by(trial)
        restarts = session.begin(trial.trial)
        where(trial)
        document.body.classList.add('showing')
      },
      on_finish: (record) => {
        document.body.classList.remove('showing')
        record.stimulus = data.stimulus
        record.restarts = restarts
        record.clip_type = Study.clips.type
        if (trial.stimulus && !used.has(trial.stimulus)) Study.clips.release(trial.stimulus)
      }
    }
  }
  const load_chosen = (trial) => ({
    timeline: [load(() => {
      const old = [...Study.clips.urls.keys()].filter((stimulus) => adaptive.stimuli.includes(stimulus))
      while (Study.clips.urls.size >= kMostLoaded && old.length > 0) Study.clips.release(old.shift())
      return [shown_by(trial)]
    })],
    conditional_function: () => !Study.clips.urls.has(shown_by(trial))
  })
  const pause = (left) => screen(
    `<h1>A break</h1><p>Rest your eyes for as long as you like. ${left === 1 ? 'One trial is' : `${left} trials are`} left.</p>
     <p id="kept" role="status"></p>`,
    ['Go on'],
    {
      on_load: async () => {
        await session.send()
        const kept = document.getElementById('kept')
        if (kept) kept.textContent = session.served ? 'All your answers so far are kept.' : 'Your answers so far are in this browser.'
      }
    })

  // ---- the timeline

  function trial_nodes() {
    const all = list().trials
    const breaks = list().breaks ?? trials.breaks ?? []
    const left = all.filter((each) => !session.has(each.trial))
    const nodes = []
    for (let at = 0; at < left.length;) {
      let end = at + 1
      const training = left[at].kind === 'training'
      while (end < left.length && end - at < kMostLoaded &&
             (left[end].block === left[at].block || training && left[end - 1].kind === 'training')) ++end
      const clips = clips_of(left.slice(at, end))
      if (clips.length > 0) nodes.push(load(clips))
      for (let i = at; i < end; ++i) {
        if (!left[i].stimulus) nodes.push(load_chosen(left[i]))
        nodes.push(one(left[i], new Set(left.slice(i + 1, end).map((each) => each.stimulus))))
        const number = all.indexOf(left[i]) + 1
        if (i + 1 < left.length && breaks.includes(number)) nodes.push(pause(all.length - number))
        if (i + 1 < left.length)
          nodes.push({
            timeline: [fullScreen(true)],
            conditional_function: () => Study.wantsFullScreen === true && !document.fullscreenElement
          })
      }
      at = end
    }
    return nodes
  }
  function before_trials() {
    const nodes = []
    const missing = (item) => !session.has(item)
    if (missing('consent')) session.add(page('consent', { agreed: true, study: trials.study, participant: session.participant }))
    if (trials.demographics?.length > 0 && missing('demographics')) nodes.push(demographics())
    nodes.push(fullScreen(false))
    nodes.push({ timeline: [small()], conditional_function: tooSmall })
    if (trials.calibration && missing('calibration')) nodes.push({ type: Study.CalibrationPlugin, data: page('calibration') })
    if (missing('vision')) nodes.push({ type: Study.VisionPlugin, seed: session.participant, data: page('vision') })
    nodes.push(instructions())
    return nodes
  }
  const comments = () => ({
    type: jsPsychSurveyHtmlForm,
    preamble: '<div class="text"><h1>Anything else?</h1></div>',
    html: `<div class="text"><p><label for="comments">Did anything go wrong, or did you notice anything? You may leave this
      empty.</label></p><textarea id="comments" name="comments" rows="4" maxlength="2000"></textarea></div>`,
    button_label: 'Finish', data: page('comments')
  })

  // ---- the end

  function download(name, type, text) {
    const link = document.createElement('a')
    link.href = URL.createObjectURL(new Blob([text], { type }))
    link.download = name
    link.click()
    setTimeout(() => URL.revokeObjectURL(link.href), 10000)
  }
  function debrief() {
    const files = session.served ? '' : `<h2>Your answers</h2><p>They are in this browser alone. Please save them and send them to
      whoever invited you.</p><p class="buttons"><button type="button" id="save-json">Save as JSON</button>
      <button type="button" id="save-csv">Save as CSV</button></p>`
    document.getElementById('where').textContent = 'Finished'
    document.getElementById('leave').textContent = 'Delete my answers'
    stage.innerHTML = `<div class="text">${Study.markdown(texts.debrief) || '<h1>Thank you</h1>'}${files}
      <p>${session.served ? 'All your answers are kept. You may close this window.' : ''}</p></div>`
    document.body.dataset.state = 'finished'
    if (session.served) return
    const rows = session.rows()
    const name = `answers-${session.participant.slice(0, 12)}`
    const collection = new jsPsychModule.DataCollection(rows)
    document.getElementById('save-json').addEventListener('click', () =>
      download(`${name}.json`, 'application/json', collection.json(true)))
    document.getElementById('save-csv').addEventListener('click', () => download(`${name}.csv`, 'text/csv', collection.csv()))
  }

  async function go() {
    if (window.location.protocol === 'file:')
      return fatal('Not from a file', 'Browsers do not let a page load clips from files. Show the folder with `crowdbench study serve`.')
    const response = await fetch('trials.json', { cache: 'no-store' })
    if (!response.ok) throw new Error('trials.json is missing')
    trials = await response.json()
    document.title = trials.title || 'Study'
    await read_texts()
    session = new Study.Session(trials.study)
    Study.clips = new Study.Clips(trials)
    if (trials.adaptive) adaptive = new Study.Adaptive(trials.adaptive, trials.study)
    session.whenTaken = taken
    Study.session = session
    await session.find()
    if (!session.state.consented && !(await consent()))
      return fatal('You did not agree', 'Nothing was kept. You may close this window.')
    await session.start(trials.lists.map((each) => each.id))
    document.getElementById('bar').hidden = false
    ready_to_leave()
    where()
    if (!session.state.finished) {
      await run([...before_trials(), ...trial_nodes(), ...(session.has('comments') ? [] : [comments()])])
      if (leaving) return undefined
      if (Study.stopped)
        return fatal('This browser does not show the clips faithfully',
          'Please open the same link in another one, such as a current Chrome or Firefox. Nothing is lost. (Protection against ' +
          'fingerprinting that changes what a page reads from pictures has the same effect.)')
      if (document.fullscreenElement) document.exitFullscreen().catch(() => {})
      await session.finish()
    }
    debrief()
    return undefined
  }

  try {
    await go()
  } catch (failure) {
    fatal('The study cannot go on', `${failure.message}. Reload the page to try again; what you have answered is kept.`)
  }
})()
