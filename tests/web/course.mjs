// Does the whole set-up course of a practice in a headless Chromium: node course.mjs ADDRESS [FOLDER FOR PICTURES]. Prints what each step
// says at its end, and a line that begins with FAILED for what does not hold.
import {checks, open} from './browser.mjs';

const [address, folder] = process.argv.slice(2);
const {browser, page, faults} = await open(address);
const kPatience = 300000;
const {check, contains, finish} = checks(page, kPatience);
const kMost = 3;  // mm

const state = () => page.evaluate(() => ({...document.querySelector('#course').dataset, text: document.querySelector('#course-text').textContent}));
const until = (step, what) => page.waitForFunction(([name, key]) => {
  const {dataset} = document.querySelector('#course');
  return dataset.step === name && (key === 'open' ? dataset.begun === 'false' : dataset[key] === 'true');
}, [step, what], {timeout: kPatience});
const picture = async name => { if (folder) await page.screenshot({path: `${folder}/course-${name}.png`}); };

async function done(step) {
  try {
    await until(step, 'done');
  } catch {
    const now = await state();
    check(false, `${step}: not done: ${JSON.stringify(now)}`);
    await picture(`${step}-failed`);
    await finish(browser, faults);
  }
  console.log(`${step}: ${(await state()).text}`);
  await picture(step);
}
async function next(step) {
  await page.click('#course-next');
  await until(step, 'open');
}

await contains('#course-robot', 'never on a real robot');  // from the first step on
await done('cameras');
await next('board');
await page.fill('#course-square', '25');
await page.click('#course-begin');
await until('board', 'begun');
await done('board');

await next('object');
await page.fill('#course-radius', '20');
await page.click('#course-begin');
await until('object', 'begun');
// Where the ball is: the middle of the pink pixels of each image, in pixels of the page.
for (const side of [0, 1]) {
  const at = await (await page.waitForFunction(half => {
    const canvas = document.querySelector('#picture'), {width, height} = canvas;
    const {data} = canvas.getContext('2d').getImageData(half * width / 2, 0, width / 2, height);
    let count = 0, x = 0, y = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (data[i] < 120 || data[i + 1] > 0.35 * data[i] || data[i + 2] > 0.75 * data[i] || data[i + 2] < 0.3 * data[i]) continue;
      ++count;
      x += i / 4 % (width / 2);
      y += Math.floor(i / 4 / (width / 2));
    }
    return count > 60 && {x: (half * width / 2 + x / count) / width, y: y / count / height};
  }, side, {timeout: kPatience})).jsonValue();
  const box = await page.locator('#picture').boundingBox();
  await page.mouse.click(box.x + at.x * box.width, box.y + at.y * box.height);
  if (side === 0) await contains('#course-text', 'Now click on the object in the right image');  // no click while another is worked on
}
await done('object');
await contains('#course-text', 'Vision sees it');

for (const step of ['pose', 'check', 'reach']) {
  await next(step);
  await page.click('#course-begin');
  if (step === 'pose') {
    await contains('#course-text', 'The arm moves slowly');
    await picture('pose-moving');
  }
  await done(step);
}
console.log(await page.$eval('#course-details', box => [...box.querySelectorAll('tr')].map(row => [...row.cells].map(cell => cell.textContent).join(' | ')).join('\n')));
const text = (await state()).text;
const rests = Number(/rests ([\d.]+) mm/.exec(text)?.[1] ?? NaN);
check(rests <= kMost, `the hand rests ${rests} mm from the ball, more than ${kMost}`);
check((await state()).complete === 'true', 'the course is not complete');
if (folder) {
  await page.keyboard.press('t');
  await picture('reach-other-theme');
}
await finish(browser, faults);
