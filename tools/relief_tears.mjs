// Prints the table of tears of renderers/relief/README.md as Markdown: for every character that walks and every
// representation, mean (worst) over 60, 120 and 240 pixels, 16 views and two moments of the walk.
// Usage: node tools/relief_tears.mjs build/release/bin/crowdbench [FOLDER_OF_CHARACTERS] [REPRESENTATION ...]
//        node tools/relief_tears.mjs build/release/bin/crowdbench --tiny
// (about half a minute a character; --tiny: one small character, view and moment, to see that it runs)
import { existsSync } from 'node:fs';
import { asks } from './driver.mjs';

const [driver, ...rest] = process.argv.slice(2);
const tiny = rest[0] === '--tiny';
if (!driver || (tiny && rest.length > 1)) {
  console.error('usage: relief_tears.mjs DRIVER [FOLDER [REPRESENTATION ...] | --tiny]');
  process.exit(2);
}
const [folder, ...given] = tiny ? [undefined, 'relief:map=32,capture=bind'] : rest;
const representations = given.length > 0 ? given : ['relief'];
const characters = [[tiny ? 'mannequin:triangles=500' : 'mannequin', 'walk']];
const walks = [['Fox', 'Walk'], ['CesiumMan', '0'], ['RiggedFigure', '0'], ['greenman', '2_move'],
  ['Robot', 'Robot_Walking'], ['KayKitKnight', 'Walking_A'], ['QuaterniusKnight', 'HumanArmature|Walking'],
  ['CyberpunkCharacter', 'CharacterArmature|Walk'], ['Mannequiny', 'walk']];
for (const [name, clip] of walks)
  if (folder && existsSync(`${folder}/${name}.glb`)) characters.push([`${folder}/${name}.glb`, clip]);
const views = tiny ? ['--height-px', '60', '--time', '0.1']
  : ['--height-px', '60,120,240', '--time', '0.1,0.4', '--azimuth-deg', '0:315:45', '--elevation-deg', '0,30'];

const ask = asks(driver);
const mean = (values) => values.reduce((sum, v) => sum + v, 0) / values.length;
const cell = (values, worst, digits) => `${mean(values).toFixed(digits)} (${worst(...values).toFixed(digits)})`;
console.log('| character | representation | holes ‰ | strays ‰ | IoU | SSIM | SSIM at 120 px |');
console.log('|---|---|---|---|---|---|---|');
for (const [character, clip] of characters) {
  const { rows } = ask('quality', ...representations.flatMap((r) => ['--representation', r]), '--character', character,
    '--clip', clip, ...views);
  for (const representation of representations) {
    const some = rows.filter((r) => r.representation === representation);
    const of = (key) => some.map((r) => r[key]);
    const at120 = some.filter((r) => r.height_px === 120).map((r) => r.ssim);
    console.log(`| ${character.replace(/.*\//, '').replace('.glb', '')} | ${representation} ` +
      `| ${cell(of('holes'), Math.max, 2)} | ${cell(of('strays'), Math.max, 2)} ` +
      `| ${cell(of('silhouette_iou'), Math.min, 3)} | ${cell(of('ssim'), Math.min, 3)} ` +
      `| ${at120.length > 0 ? mean(at120).toFixed(3) : '-'} |`);
  }
}
