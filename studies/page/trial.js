// Trial: a clip is shown, then one of the answers is chosen by button or key.
(function () {
  'use strict'

  const key = (text) => (text ? ` <kbd>${Study.escape(text.toUpperCase())}</kbd>` : '')

  // How large a clip of so many pixels is shown: one of its pixels on one of the screen (scale 1) where that fits, else as
  // large as fits. beside: with question and answers at its sides, where it is higher than the window leaves room for
  // above and below.
  const kAboveAndBelow = 190
  const kAtEitherSide = 240
  Study.fit = (width, height) => {
    const ratio = window.devicePixelRatio
    const across = document.documentElement.clientWidth || window.innerWidth
    const bar = document.getElementById('bar').offsetHeight + 20
    const scale = (roomAcross, room) => Math.min(1, Math.max(120, roomAcross) / (width / ratio), Math.max(120, room) / (height / ratio))
    const stacked = scale(across, window.innerHeight - kAboveAndBelow)
    const wide = scale(across - 2 * kAtEitherSide, window.innerHeight - bar)
    return wide > stacked ? { scale: wide, beside: true } : { scale: stacked, beside: false }
  }

  // jsPsych plugin. Answers are taken once the clip was shown to its end; the clip may then be shown again `replays` times.
  // A showing during which the page was hidden does not count: it begins anew when the page is seen again.
  class TrialPlugin {
    static info = {
      name: 'crowdbench-trial',
      version: '1.0.0',
      parameters: {
        url: { type: jsPsychModule.ParameterType.STRING, default: undefined },
        question: { type: jsPsychModule.ParameterType.STRING, default: '' },
        answers: { type: jsPsychModule.ParameterType.OBJECT, array: true, default: [] },
        replays: { type: jsPsychModule.ParameterType.INT, default: 0 },
        frames: { type: jsPsychModule.ParameterType.INT, default: 0 },
        width: { type: jsPsychModule.ParameterType.INT, default: 0 },
        height: { type: jsPsychModule.ParameterType.INT, default: 0 }
      },
      data: {}
    }
    constructor(jsPsych) { this.jsPsych = jsPsych }

    trial(display, trial) {
      this.display = display
      this.parameters = trial
      this.shown = { replays: 0, interrupted: 0, longest_gap_ms: 0 }
      this.frames = { total: 0, dropped: 0 }  // of whole showings
      this.firstEnd = null
      Study.window.begin()
      this.build()
      this.video.src = trial.url
      this.watch()
      this.video.addEventListener('ended', () => this.ended())
      this.video.addEventListener('error', () => this.failed())
      this.play()
    }

    build() {
      const t = this.parameters
      this.display.innerHTML = `<div class="trial"><h1 id="ask" tabindex="-1">${Study.escape(t.question)}</h1>
        <video id="clip" muted playsinline disablepictureinpicture aria-label="Clip: two crowds, one above the other"></video>
        <div class="below"><div class="answers" role="group" aria-labelledby="ask">
        ${t.answers.map((a) => `<button type="button" value="${Study.escape(a.value)}">${Study.escape(a.label)}${key(a.key)}</button>`).join('')}
        </div><p class="replay"><button type="button" id="replay" class="quiet"></button></p></div></div>`
      this.video = this.display.querySelector('#clip')
      this.video.muted = true
      this.fit()
      this.resized = () => this.fit()
      window.addEventListener('resize', this.resized)
      for (const button of this.display.querySelectorAll('.answers button'))
        button.addEventListener('click', () => this.answer(button.value, 'button'))
      this.display.querySelector('#replay').addEventListener('click', () => this.replay())
      this.open(false)
    }

    fit() {
      const t = this.parameters
      const { scale, beside } = Study.fit(t.width, t.height)
      this.cssWidth = t.width / window.devicePixelRatio * scale
      this.video.style.width = `${this.cssWidth}px`
      this.display.querySelector('.trial').classList.toggle('beside', beside)
    }

    open(yes) {
      const t = this.parameters
      const left = t.replays - this.shown.replays
      for (const button of this.display.querySelectorAll('.answers button')) button.disabled = !yes
      const replay = this.display.querySelector('#replay')
      replay.disabled = !yes || left <= 0
      replay.hidden = t.replays === 0
      replay.innerHTML = `Show again (${left} left)${key('r')}`
      this.display.querySelector('.trial').classList.toggle('open', yes)
    }

    play() {
      this.spoiled = document.hidden
      this.over = false
      this.before = this.quality()
      this.video.currentTime = 0
      this.lastFrame = null
      this.video.play().catch(() => this.failed())
    }
    // Frames since the clip was loaded; a spoiled showing's are taken off.
    quality() {
      const quality = this.video.getVideoPlaybackQuality?.()
      return { total: quality?.totalVideoFrames ?? null, dropped: quality?.droppedVideoFrames ?? null }
    }
    // How long the longest picture stayed on the screen, as the page's own frames tell.
    watch() {
      const look = (now) => {
        if (!this.video) return
        const playing = !this.video.paused && !this.video.ended && !this.spoiled
        if (playing && this.lastFrame !== null)
          this.shown.longest_gap_ms = Math.max(this.shown.longest_gap_ms, Math.round(now - this.lastFrame))
        this.lastFrame = playing ? now : null
        requestAnimationFrame(look)
      }
      requestAnimationFrame(look)
      this.visible = () => {
        if (document.hidden) {
          // Also where the clip has ended and nobody was told so yet: that end would be out of sight.
          if (!this.over) this.spoiled = true
        } else if (this.spoiled) {
          ++this.shown.interrupted
          this.play()
        }
      }
      document.addEventListener('visibilitychange', this.visible)
    }

    ended() {
      if (this.over || !this.video.ended) return  // told late, of a showing that began anew meanwhile
      if (document.hidden) this.spoiled = true
      if (this.spoiled) return  // shown anew when the page is seen again
      this.over = true
      const now = this.quality()
      // Counters that run backwards began anew with the clip: how many frames were shown is not known then.
      const total = now.total - this.before.total
      const dropped = now.dropped - this.before.dropped
      if (now.total !== null && this.frames.total !== null && dropped >= 0 && total >= dropped) {
        this.frames.total += total
        this.frames.dropped += dropped
      } else {
        this.frames = { total: null, dropped: null }
      }
      if (this.firstEnd === null) {
        this.firstEnd = performance.now()
        const keys = this.parameters.answers.map((a) => a.key).filter(Boolean)
        this.listener = this.jsPsych.pluginAPI.getKeyboardResponse({
          callback_function: ({ key: pressed }) => this.pressed(pressed.toLowerCase()),
          valid_responses: [...keys, ...keys.map((k) => k.toUpperCase()), 'r', 'R'], persist: true, allow_held_key: false
        })
      }
      this.open(true)
    }
    // A broken clip says so twice: by its event, and by refusing to play.
    failed() {
      if (!this.video || this.retrying) return
      this.retrying = true
      Study.notice('The clip stopped. It begins again in a moment; reload the page if it does not.')
      setTimeout(() => {
        this.retrying = false
        if (!this.video) return
        Study.notice('')
        this.video.load()
        this.play()
      }, 2000)
    }
    replay() {
      if (this.shown.replays >= this.parameters.replays) return
      ++this.shown.replays
      this.open(false)
      this.display.querySelector('#ask').focus()
      this.play()
    }
    pressed(pressed) {
      if (!this.display.querySelector('.trial.open') || document.querySelector('dialog[open]')) return
      const chosen = this.parameters.answers.find((a) => a.key?.toLowerCase() === pressed)
      if (chosen) this.answer(chosen.value, 'key')
      else if (pressed === 'r') this.replay()
    }

    answer(value, by) {
      const rt = Math.round(performance.now() - this.firstEnd)
      this.jsPsych.pluginAPI.cancelAllKeyboardResponses()
      window.removeEventListener('resize', this.resized)
      document.removeEventListener('visibilitychange', this.visible)
      this.video.pause()
      const data = {
        answer: value, answered_by: by, rt_ms: rt, ...this.shown,
        frames_total: this.frames.total, frames_dropped: this.frames.dropped, frames: this.parameters.frames, css_px_per_clip_px: this.cssWidth / this.parameters.width, ...Study.window.since()
      }
      this.video = null
      this.display.innerHTML = ''
      this.jsPsych.finishTrial(data)
    }
  }
  Study.TrialPlugin = TrialPlugin
})()
