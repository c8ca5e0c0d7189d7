// Vision: whether faint differences of brightness and of colour reach the participant, through this screen and these eyes.
// Five plates with a digit each; what was answered is recorded and nobody is turned away. Not a medical test.
(function () {
  'use strict'

  // Rows of a digit, five columns each, from the top; the highest of five bits is left.
  const kDigits = {
    2: [14, 17, 1, 2, 4, 8, 31], 3: [14, 17, 1, 6, 1, 17, 14], 4: [2, 6, 10, 18, 31, 2, 2], 5: [31, 16, 30, 1, 1, 17, 14],
    6: [6, 8, 16, 30, 17, 17, 14], 7: [31, 1, 2, 4, 8, 8, 8], 8: [14, 17, 17, 14, 17, 17, 14], 9: [14, 17, 17, 15, 1, 2, 12]
  }
  // Colours of the ground and of the digit, sRGB; `spread`: how much the dots' brightness varies, so that brightness alone
  // does not show a digit that differs in hue.
  const kPlates = [
    { plate: 'plain', ground: [150, 150, 150], digit: [60, 60, 60], spread: 0.1 },
    { plate: 'dark', ground: [12, 12, 12], digit: [24, 24, 24], spread: 0 },
    { plate: 'light', ground: [250, 250, 250], digit: [240, 240, 240], spread: 0 },
    { plate: 'red-green', ground: [128, 140, 72], digit: [186, 116, 72], spread: 0.25 },
    { plate: 'blue-yellow', ground: [126, 132, 118], digit: [118, 126, 176], spread: 0.25 }
  ]
  const kCells = 22  // of a plate's width and height
  const kSize = 330  // pixels

  // Numbers in [0, 1) that follow from a text.
  const numbers = (text) => {
    let digest = Study.sha256(text)
    let at = 0
    return () => {
      if (at + 8 > digest.length) {
        digest = Study.sha256(digest)
        at = 0
      }
      at += 8
      return parseInt(digest.slice(at - 8, at), 16) / 4294967296
    }
  }

  const shows = (digit, column, row) => {
    const x = Math.floor((column - 6) / 2)
    const y = Math.floor((row - 4) / 2)
    return x >= 0 && x < 5 && y >= 0 && y < 7 && (kDigits[digit][y] >> (4 - x)) % 2 === 1
  }
  function draw(canvas, plate, digit, next) {
    const context = canvas.getContext('2d')
    const cell = kSize / kCells
    const colour = (rgb, factor) => `rgb(${rgb.map((c) => Math.round(Math.min(255, c * factor))).join(' ')})`
    const dots = plate.spread > 0
    context.fillStyle = dots ? '#fff' : colour(plate.ground, 1)
    context.fillRect(0, 0, kSize, kSize)
    for (let row = 0; row < kCells; ++row)
      for (let column = 0; column < kCells; ++column) {
        const inside = shows(digit, column, row)
        context.fillStyle = colour(inside ? plate.digit : plate.ground, 1 + plate.spread * (2 * next() - 1))
        if (dots) {
          context.beginPath()
          context.arc((column + 0.5) * cell, (row + 0.5) * cell, cell * (0.34 + 0.14 * next()), 0, 2 * Math.PI)
          context.fill()
        } else if (inside) {
          context.fillRect(column * cell, row * cell, cell + 0.5, cell + 0.5)
        }
      }
  }

  class VisionPlugin {
    static info = {
      name: 'crowdbench-vision',
      version: '1.0.0',
      parameters: { seed: { type: jsPsychModule.ParameterType.STRING, default: '' } },
      data: {}
    }
    constructor(jsPsych) { this.jsPsych = jsPsych }

    async trial(display, trial) {
      const next = numbers(`vision/${trial.seed}`)
      const plates = []
      for (const [number, plate] of kPlates.entries()) {
        const digit = String(2 + Math.floor(8 * next()))
        display.innerHTML = `<div class="text"><h1 id="ask">Which digit do you see?</h1>
          <canvas id="plate" width="${kSize}" height="${kSize}" role="img" aria-label="A picture of a digit"></canvas>
          <p class="count">${number + 1} of ${kPlates.length}</p>
          <div class="digits" role="group" aria-labelledby="ask">
          ${[2, 3, 4, 5, 6, 7, 8, 9].map((d) => `<button type="button" value="${d}">${d}</button>`).join('')}
          <button type="button" value="none">none <kbd>N</kbd></button></div></div>`
        draw(display.querySelector('#plate'), plate, digit, next)
        plates.push({ plate: plate.plate, shown: digit, answered: await this.answer(display) })
      }
      display.innerHTML = ''
      this.jsPsych.finishTrial({ plates, plates_right: plates.filter((p) => p.shown === p.answered).length })
    }
    answer(display) {
      return new Promise((resolve) => {
        const end = (value) => {
          document.removeEventListener('keydown', key)
          resolve(value)
        }
        const key = (event) => {
          if (document.querySelector('dialog[open]')) return
          if (/^[2-9]$/.test(event.key)) end(event.key)
          if (event.key.toLowerCase() === 'n') end('none')
        }
        document.addEventListener('keydown', key)
        for (const button of display.querySelectorAll('.digits button'))
          button.addEventListener('click', () => end(button.value))
      })
    }
  }
  Study.VisionPlugin = VisionPlugin
})()
