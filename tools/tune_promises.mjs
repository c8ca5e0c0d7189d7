// How often what `tune` promises holds: on unseen seeds of the characters that were tuned, and on a character that was not.
// Markdown on stdout.
//
//   node tools/tune_promises.mjs DRIVER FOLDER --characters C;C;C;C [--seeds 20] [--candidates R;R] [--threshold S=V] [--kept yes]
//   node tools/tune_promises.mjs DRIVER FOLDER --tiny    one of each on the built-in character, to see that it runs
//
// FOLDER keeps what was found (a JSON a tuning): ended and started again, it goes on where it was; with --kept yes it tells what is
// there and measures nothing. Every character is tuned alone
// and held against its promise on so many unseen seeds. Every character is then unseen once: the three that follow it in the
// list are tuned together. Small pictures and crowds: what is asked is how often intervals hold, not how wide they are at a
// size that anybody would use.
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import { asks } from './driver.mjs';

function usage(message) {
  console.error(`tune_promises: ${message}\nusage: tune_promises.mjs DRIVER FOLDER --characters C;C;C;C [--seeds N] ` +
    '[--candidates R;R] [--threshold SCORE=VALUE] [--kept yes] | --tiny');
  process.exit(2);
}
const [driver, folder, ...rest] = process.argv.slice(2);
if (!driver || !folder) usage('the driver and a folder are needed');
const tiny = rest.length === 1 && rest[0] === '--tiny';
const given = { '--characters': '', '--seeds': '20', '--candidates': 'mesh:triangles=300;flat:views=hemi-8', '--threshold': 'cvvdp=7', '--kept': '' };
for (let i = 0; i < rest.length && !tiny; i += 2) {
  if (!(rest[i] in given) || rest[i + 1] === undefined) usage(`'${rest[i]}' is not understood`);
  given[rest[i]] = rest[i + 1];
}
const characters = tiny ? ['mannequin:triangles=500', 'mannequin:triangles=2200', 'mannequin:triangles=5000', 'mannequin'] : given['--characters'].split(';').filter(Boolean);
if (new Set(characters).size < 4) usage('four characters are needed at least: three to tune, one to leave out');
const seeds = tiny ? 2 : Number(given['--seeds']);
if (!(seeds >= 1 && seeds <= 1000)) usage(`'${given['--seeds']}' is not a number of seeds`);
const common = tiny
  ? ['--representation', 'mesh:triangles=100', '--agents', '6', '--size', '96x72', '--heights', '2', '--views', '4', '--moments', '1',
    '--rounds', '4', '--threshold', 'mae=255', '--prove-figures', '2', '--promise-seeds', '3']
  : [...given['--candidates'].split(';').flatMap((r) => ['--representation', r]), '--agents', '60', '--size', '320x180',
    '--nearest-px', '80', '--heights', '3', '--views', '36', '--moments', '4', '--rounds', '8', '--threshold', given['--threshold']];
// A switch between such coarse candidates is seen; what is asked here is not whether.
const pop = ['--pop-threshold', tiny ? 'mae=255' : given['--threshold'].replace(/=.*/, '=0')];
mkdirSync(folder, { recursive: true });

const name_of = (character) => basename(character).replace(/\.[a-z]+$/, '').replace(/[^A-Za-z0-9=_-]/g, '_');
const ask = asks(driver, [0, 1]); // 1: a promise that does not hold
// A seed of its own for each tuning: figures of one seed look from the same sides at every character, and would be lucky
// or not for all of them together.
function tuned(name, seed, ...args) {
  const path = join(folder, `${name}.json`);
  if (!existsSync(path) && given['--kept']) return null;
  if (!existsSync(path)) writeFileSync(path, JSON.stringify(ask('tune', '--seed', `${seed}`, ...args, ...common, ...pop, '--prove', `${seeds}`), null, 2));
  return JSON.parse(readFileSync(path, 'utf8'));
}

const within = (interval, value) => value >= interval.low - 1e-9 && value <= interval.high + 1e-9;
const range = (interval, digits) => `${interval.low.toFixed(digits)} to ${interval.high.toFixed(digits)}`;
const percent = (part, all) => all > 0 ? `${(100 * part / all).toFixed(1)} %` : '-';

// Every five seeds that follow each other, made into a promise of the score as the driver makes one (promised_score in
// bench/experiments/tune_proof.h), and held against all other seeds: one promise alone is lucky or not.
function student_975(degrees) { // Cornish and Fisher's expansion; to 0.001 from 10 degrees on
  const z = 1.959964;
  return z + (z ** 3 + z) / (4 * degrees) + (5 * z ** 5 + 16 * z ** 3 + 3 * z) / (96 * degrees ** 2) +
    (3 * z ** 7 + 19 * z ** 5 + 17 * z ** 3 - 15 * z) / (384 * degrees ** 3);
}
function by_fives(seeds) {
  const said = { within: 0, all: 0 };
  for (let first = 0; first + 5 <= seeds.length; first += 5) {
    const of = seeds.slice(first, first + 5);
    const variances = of[0].values.map((_, place) => {
      const values = of.map((seed) => seed.values[place]);
      const mean = values.reduce((a, b) => a + b) / 5;
      return values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / 4;
    });
    const sum = variances.reduce((a, b) => a + b);
    const degrees = sum ** 2 / variances.reduce((all, one) => all + one ** 2 / 4, 0);
    const mean = of.reduce((all, seed) => all + seed.mean, 0) / 5;
    const half = student_975(degrees) * Math.sqrt(sum * 1.2) / variances.length;
    for (const seed of seeds)
      if (!of.includes(seed)) {
        said.all += 1;
        said.within += Math.abs(seed.mean - mean) <= half;
      }
  }
  return said;
}

console.log('## Unseen seeds of the character that was tuned\n');
console.log('| character | rule | promised speed | within | promised score | within | of other seeds, by every five | figures worse than promised |\n|---|---|---|---|---|---|---|---|');
const sums = { speed: 0, score: 0, seeds: 0, fives: 0, others: 0, worse: 0, figures: 0 };
for (const [i, character] of (tiny ? characters.slice(0, 1) : characters).entries()) {
  const one = tuned(`alone-${name_of(character)}`, 101 + i, '--character', character);
  if (!one) continue;
  if (!one.proof) {
    console.log(`| ${name_of(character)} | ${one.no_plan ?? 'nothing was promised'} | | | | | | |`);
    continue;
  }
  const { speed, score, errors: [error] } = one.proof;
  const fives = by_fives([...one.promise.score.seeds, ...score.seeds]);
  console.log(`| ${name_of(character)} | ${one.representation} | ${range(one.promise.on_another_seed, 2)} | ${speed.within} of ${seeds} | ` +
    `${range(one.promise.score.on_another_seed, 3)} | ${score.within} of ${seeds} | ${fives.within} of ${fives.all} | ${error.worse_than_promised} of ${error.figures} |`);
  sums.speed += speed.within;
  sums.score += score.within;
  sums.seeds += seeds;
  sums.fives += fives.within;
  sums.others += fives.all;
  sums.worse += error.worse_than_promised;
  sums.figures += error.figures;
}
console.log(`| all | stated: 95 % | | ${percent(sums.speed, sums.seeds)} | | ${percent(sums.score, sums.seeds)} | ${percent(sums.fives, sums.others)} | ` +
  `${percent(sums.worse, sums.figures)}, at most 5 % stated |\n`);

console.log('## A character that was not tuned, by the rule of three others\n');
console.log('In brackets what would have been promised were the three all there is: the interval for another seed of them.\n');
console.log('| not tuned | tuned | promised speed | found | promised mean score | found | promised at the bad end\'s 5 % | found |');
console.log('|---|---|---|---|---|---|---|---|');
const others = { characters: 0, speed: 0, mean: 0, tail: 0, plain_speed: 0, plain_mean: 0 };
const mark = (holds) => (holds ? '' : ' **not**');
for (let i = 0; i < (tiny ? 1 : characters.length); ++i) {
  const three = [1, 2, 3].map((k) => characters[(i + k) % characters.length]);
  const one = tuned(`unseen-${name_of(characters[i])}`, 201 + i, '--character', three[0], '--also-character', three[1], '--also-character', three[2],
    '--prove-on', characters[i]);
  if (!one) continue;
  if (!one.proof) {
    console.log(`| ${name_of(characters[i])} | ${three.map(name_of).join(', ')} | ${one.no_plan ?? 'nothing was promised'} | | | | | |`);
    continue;
  }
  const promise = one.promise_of_others;
  const { drawn, speed_within, mean_within, worst_5_percent_within } = one.proof;
  console.log(`| ${name_of(characters[i])} | ${three.map(name_of).join(', ')} | ${range(promise.reference_over_plan_of_another, 2)} ` +
    `(${range(one.promise.on_another_seed, 2)}) | ${drawn.reference_over_plan.toFixed(2)}${mark(speed_within)} | ` +
    `${range(promise.mean_of_another, 2)} (${range(one.promise.score.on_another_seed, 2)}) | ${drawn.mean.toFixed(2)}${mark(mean_within)} | ` +
    `${range(promise.worst_5_percent_of_another, 2)} | ${drawn.worst_5_percent.toFixed(2)}${mark(worst_5_percent_within)} |`);
  others.characters += 1;
  others.speed += speed_within;
  others.mean += mean_within;
  others.tail += worst_5_percent_within;
  others.plain_speed += within(one.promise.on_another_seed, drawn.reference_over_plan);
  others.plain_mean += within(one.promise.score.on_another_seed, drawn.mean);
}
const of = (count) => `${count} of ${others.characters}`;
console.log(`| within | stated: 95 % | ${of(others.speed)} (${of(others.plain_speed)}) | | ${of(others.mean)} (${of(others.plain_mean)}) | | ${of(others.tail)} | |`);
