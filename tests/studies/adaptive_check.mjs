// The page's choices against those of the C++ rule: node adaptive_check.mjs PAGE_FOLDER CASES.json. A case has the rule as
// trials.json holds it, and trials with what was answered before each and what was chosen; status 0 where the page chooses
// the same in every one. Prints how many it compared.
import assert from 'node:assert/strict'
import { readFileSync } from 'node:fs'
import { join } from 'node:path'
import vm from 'node:vm'

const world = vm.createContext({ TextEncoder })
world.window = world
for (const file of ['text.js', 'adaptive.js']) vm.runInContext(readFileSync(join(process.argv[2], file), 'utf8'), world)
const Adaptive = vm.runInContext('Study.Adaptive', world)

let compared = 0
for (const { name, rule, study, list, trials } of JSON.parse(readFileSync(process.argv[3], 'utf8'))) {
  const adaptive = new Adaptive(rule, study)
  for (const { trial, before, chosen, worths } of trials) {
    adaptive.worths(before).forEach((worth, choice) =>
      assert.ok(Math.abs(worth - worths[choice]) < 1e-10, `${name}, ${trial}: ${worth} is not ${worths[choice]}`))
    assert.equal(adaptive.choose(list, trial, before), chosen, `${name}, ${trial}`)
    ++compared
  }
}
console.log(compared)
