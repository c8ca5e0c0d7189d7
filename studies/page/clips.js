// Clips: which file this browser shows faithfully, and files in memory before they are played.
(function () {
  'use strict'

  // How far a colour of the known frame, the mean of 5 x 5 pixels, may be off where the study does not say, of 255: another
  // colour matrix or range is further off.
  const kTolerance = 12

  // Bytes of a file, with what arrived told to `arrived`. Throws with a reason in words.
  async function bytes(source, arrived) {
    const response = await fetch(source).catch(() => { throw new Error('the connection was lost') })
    if (!response.ok) throw new Error(`the server answers ${response.status} for ${source}`)
    const total = Number(response.headers.get('Content-Length')) || 0
    const parts = []
    let got = 0
    for (const reader = response.body.getReader(); ;) {
      const { done, value } = await reader.read().catch(() => { throw new Error('the connection was lost') })
      if (done) break
      parts.push(value)
      got += value.length
      arrived(got, total)
    }
    // Of a file that was compressed on its way, the length is that of what was sent.
    if (total > 0 && got !== total && !response.headers.get('Content-Encoding')) throw new Error(`${source} arrived cut short`)
    return new Blob(parts)
  }

  // Clips are cached under their address, and s001.mp4 is there in every study: the contents are part of it.
  const at = (file) => (file.sha256 ? `${file.src}?${file.sha256.slice(0, 16)}` : file.src)

  async function verify(blob, file) {
    if (!file.sha256 || !window.crypto?.subtle) return
    const digest = new Uint8Array(await crypto.subtle.digest('SHA-256', await blob.arrayBuffer()))
    const hex = Array.from(digest, (b) => b.toString(16).padStart(2, '0')).join('')
    if (hex !== file.sha256) throw new Error(`${file.src} arrived damaged`)
  }

  const event = (target, name, ms) => new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error(`no ${name} after ${ms / 1000} s`)), ms)
    target.addEventListener(name, () => { clearTimeout(timer); resolve() }, { once: true })
    target.addEventListener('error', () => { clearTimeout(timer); reject(new Error('the clip cannot be decoded')) }, { once: true })
  })

  // The largest difference of the known frame's colours from what the browser draws now.
  function differenceNow(context, video, check) {
    context.drawImage(video, 0, 0)
    let worst = 0  // of the means
    for (const { x, y, rgb } of check.colours) {
      const seen = context.getImageData(x - 2, y - 2, 5, 5).data
      for (let i = 0; i < 3; ++i) {
        let sum = 0
        for (let at = i; at < seen.length; at += 4) sum += seen[at]
        worst = Math.max(worst, Math.abs(sum / 25 - rgb[i]))
      }
    }
    return worst
  }

  // That difference once the frame has arrived: Chromium says so before it draws it. One that never comes right stays wrong.
  async function worstDifference(url, check, fps, tolerance) {
    const video = document.createElement('video')
    video.muted = true
    video.preload = 'auto'
    video.src = url
    await event(video, 'loadeddata', 20000)
    const arrived = event(video, 'seeked', 20000)
    video.currentTime = (check.index + 0.5) / fps
    await arrived
    const canvas = document.createElement('canvas')
    canvas.width = video.videoWidth
    canvas.height = video.videoHeight
    const context = canvas.getContext('2d', { willReadFrequently: true })
    let worst = differenceNow(context, video, check)
    for (let tries = 0; worst > tolerance && tries < 20; ++tries) {
      await Study.sleep(50)
      worst = Math.min(worst, differenceNow(context, video, check))
    }
    video.removeAttribute('src')
    video.load()
    return worst
  }

  class Clips {
    constructor(trials) {
      this.trials = trials
      this.urls = new Map()  // stimulus -> blob URL
      this.type = null       // of the files that this browser shows faithfully
      this.tried = []        // what was tried before the first trial, for the record
    }
    files(stimulus) { return this.trials.stimuli[stimulus].files }

    // Chooses a type by the known frame of one stimulus; false where the browser shows none faithfully. What the browser
    // says of a type decides the order alone: Firefox plays H.264 4:4:4 on some systems and denies it.
    async choose(stimulus) {
      const check = this.trials.stimuli[stimulus].check_frame
      const tolerance = check.tolerance ?? kTolerance
      const probe = document.createElement('video')
      const denied = (file) => probe.canPlayType(file.type) === ''
      const files = this.files(stimulus)
      for (const file of [...files.filter((each) => !denied(each)), ...files.filter(denied)]) {
        const says = probe.canPlayType(file.type)
        const tried = { type: file.type, can_play: says, worst_difference: null, failure: null }
        this.tried.push(tried)
        const blob = await bytes(at(file), () => {})
        const url = URL.createObjectURL(new Blob([blob], { type: file.type.split(';')[0] }))
        try {
          tried.worst_difference = await worstDifference(url, check, this.trials.fps, tolerance)
        } catch (failure) {
          tried.failure = failure.message
        }
        URL.revokeObjectURL(url)
        if (tried.failure === null && tried.worst_difference <= tolerance) {
          this.type = file.type
          return true
        }
      }
      return false
    }

    // Loads these stimuli; told(got, of, bytes) as they arrive. Throws with a reason in words.
    async load(stimuli, told) {
      let before = 0
      for (const [number, stimulus] of stimuli.entries()) {
        if (this.urls.has(stimulus)) continue
        const file = this.files(stimulus).find((each) => each.type === this.type)
        if (!file) throw new Error(`${stimulus} has no file of the type that this browser shows`)
        const blob = await bytes(at(file), (got, total) => {
          told(number + (total > 0 ? got / total : 0), stimuli.length, before + got)
        })
        await verify(blob, file)
        before += blob.size
        this.urls.set(stimulus, URL.createObjectURL(new Blob([blob], { type: file.type.split(';')[0] })))
      }
      told(stimuli.length, stimuli.length, before)
    }
    release(stimulus) {
      URL.revokeObjectURL(this.urls.get(stimulus))
      this.urls.delete(stimulus)
    }
  }

  // jsPsych plugin: loads clips with progress; on failure says why and tries again when told to.
  class LoadPlugin {
    static info = {
      name: 'crowdbench-load',
      version: '1.0.0',
      parameters: {
        stimuli: { type: jsPsychModule.ParameterType.STRING, array: true, default: undefined },
        choose: { type: jsPsychModule.ParameterType.BOOL, default: false }
      },
      data: {}
    }
    constructor(jsPsych) { this.jsPsych = jsPsych }

    async trial(display, trial) {
      display.innerHTML = `<div class="text"><h1>Loading clips</h1>
        <progress id="loaded" max="${trial.stimuli.length}" value="0" aria-label="Clips loaded"></progress>
        <p id="loading" role="status"></p><p class="buttons"><button type="button" id="again" hidden>Try again</button></p></div>`
      const say = (text) => { display.querySelector('#loading').textContent = text }
      for (;;) {
        try {
          if (trial.choose && !Study.clips.type && !(await Study.clips.choose(trial.stimuli[0]))) {
            this.jsPsych.finishTrial({ tried: Study.clips.tried, clip_type: null })
            return
          }
          await Study.clips.load(trial.stimuli, (done, of, size) => {
            display.querySelector('#loaded').value = done
            say(`${Math.floor(done)} of ${of} clips, ${(size / 1e6).toFixed(1)} MB`)
          })
          break
        } catch (failure) {
          say(`The clips could not be loaded: ${failure.message}. Check your connection and try again; what you have ` +
            'answered is kept.')
          await this.asked(display.querySelector('#again'))
        }
      }
      this.jsPsych.finishTrial({ tried: Study.clips.tried, clip_type: Study.clips.type })
    }
    asked(button) {
      button.hidden = false
      button.focus()
      return new Promise((resolve) => button.addEventListener('click', () => {
        button.hidden = true
        resolve()
      }, { once: true }))
    }
  }

  Study.Clips = Clips
  Study.LoadPlugin = LoadPlugin
})()
