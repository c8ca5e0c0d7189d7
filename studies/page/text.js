// Text: what a study's author wrote, as HTML without markup of theirs; and hashes.
var Study = {};
(function () {
  'use strict'

  Study.escape = (text) => String(text).replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`)

  // What stands within a line: code, bold, italics, links.
  const inline = (text) =>
    Study.escape(text)
      .replace(/`([^`]+)`/g, '<code>$1</code>')
      .replace(/\*\*([^*]+)\*\*/g, '<strong>$1</strong>')
      .replace(/\*([^*]+)\*/g, '<em>$1</em>')
      .replace(/\[([^\]]+)\]\(((?:https?:\/\/|mailto:)[^)\s]+)\)/g,
        '<a href="$2" target="_blank" rel="noopener noreferrer">$1</a>')

  const list = (lines, mark, tag) => {
    const items = []
    for (const line of lines) {
      if (mark.test(line)) items.push(line.replace(mark, ''))
      else items[items.length - 1] += ' ' + line.trim()
    }
    return `<${tag}>${items.map((item) => `<li>${inline(item)}</li>`).join('')}</${tag}>`
  }

  // Of Markdown: headings, paragraphs, lists, and inline().
  Study.markdown = (source) =>
    String(source).replace(/\r/g, '').split(/\n\s*\n/).map((block) => {
      const lines = block.split('\n').filter((line) => line.trim() !== '')
      if (lines.length === 0) return ''
      const heading = /^(#{1,4})\s+(.*)$/.exec(lines[0])
      if (heading) {
        const level = heading[1].length
        const rest = lines.slice(1).join('\n')
        return `<h${level}>${inline(heading[2])}</h${level}>${rest ? Study.markdown(rest) : ''}`
      }
      if (/^\s*[-*]\s+/.test(lines[0])) return list(lines, /^\s*[-*]\s+/, 'ul')
      if (/^\s*\d+[.)]\s+/.test(lines[0])) return list(lines, /^\s*\d+[.)]\s+/, 'ol')
      // A list right below a line of text.
      const at = lines.findIndex((line) => /^\s*([-*]|\d+[.)])\s+/.test(line))
      if (at > 0) return `<p>${inline(lines.slice(0, at).join(' '))}</p>${Study.markdown(lines.slice(at).join('\n'))}`
      return `<p>${inline(lines.join(' '))}</p>`
    }).join('\n')

  // The first 32 bits behind the point of the n-th root of the first `count` primes: SHA-256's constants.
  const roots = (count, n) => {
    const out = []
    for (let candidate = 2; out.length < count; ++candidate) {
      let prime = true
      for (let d = 2; d * d <= candidate; ++d) prime = prime && candidate % d !== 0
      const root = Math.pow(candidate, 1 / n)
      if (prime) out.push(((root - Math.floor(root)) * 4294967296) >>> 0)
    }
    return out
  }
  const rotate = (x, n) => (x >>> n) | (x << (32 - n))

  function compress(state, words, k) {
    for (let i = 16; i < 64; ++i) {
      const s0 = rotate(words[i - 15], 7) ^ rotate(words[i - 15], 18) ^ (words[i - 15] >>> 3)
      const s1 = rotate(words[i - 2], 17) ^ rotate(words[i - 2], 19) ^ (words[i - 2] >>> 10)
      words[i] = (words[i - 16] + s0 + words[i - 7] + s1) | 0
    }
    let [a, b, c, d, e, f, g, h] = state
    for (let i = 0; i < 64; ++i) {
      const s1 = rotate(e, 6) ^ rotate(e, 11) ^ rotate(e, 25)
      const t1 = (h + s1 + ((e & f) ^ (~e & g)) + k[i] + words[i]) | 0
      const s0 = rotate(a, 2) ^ rotate(a, 13) ^ rotate(a, 22)
      const t2 = (s0 + ((a & b) ^ (a & c) ^ (b & c))) | 0;
      [h, g, f, e, d, c, b, a] = [g, f, e, (d + t1) | 0, c, b, a, (t1 + t2) | 0]
    }
    const sums = [a, b, c, d, e, f, g, h]
    return state.map((value, i) => (value + sums[i]) | 0)
  }

  // SHA-256 (FIPS 180-4) of a text's UTF-8, as hexadecimal digits. The browser's own exists in secure contexts only, and
  // a laboratory's network may be none.
  Study.sha256 = (text) => {
    const bytes = new TextEncoder().encode(text)
    const padded = new Uint8Array(((bytes.length + 72) >> 6) << 6)
    padded.set(bytes)
    padded[bytes.length] = 0x80
    const view = new DataView(padded.buffer)
    view.setUint32(padded.length - 8, Math.floor(bytes.length / 536870912))
    view.setUint32(padded.length - 4, (bytes.length << 3) >>> 0)
    const k = roots(64, 3)
    let state = roots(8, 2).map((value) => value | 0)
    for (let at = 0; at < padded.length; at += 64) {
      const words = new Int32Array(64)
      for (let i = 0; i < 16; ++i) words[i] = view.getInt32(at + 4 * i)
      state = compress(state, words, k)
    }
    return state.map((value) => (value >>> 0).toString(16).padStart(8, '0')).join('')
  }

  // Mean and standard error of the mean.
  Study.mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length
  Study.standardError = (values) => {
    const mean = Study.mean(values)
    const squares = values.reduce((sum, value) => sum + (value - mean) ** 2, 0)
    return values.length < 2 ? null : Math.sqrt(squares / (values.length - 1) / values.length)
  }
})()
