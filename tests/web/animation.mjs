// Pictures of the page of a log, one for every step of its time line: node animation.mjs ADDRESS FOLDER FROM_S TO_S STEP_S.
import {open} from './browser.mjs';

const [address, folder, from, to, step] = [...process.argv.slice(2, 4), ...process.argv.slice(4).map(Number)];
const {browser, page} = await open(address);
const shown = second => page.waitForFunction(at => Math.abs(Number(document.querySelector('#log-position').textContent.split(' ')[0]) - at) < 0.04, second);
await page.waitForFunction(() => Number(document.querySelector('#time-line')?.dataset.pictures) > 5);
const line = await page.locator('#time-line').boundingBox();
const seconds = Number(/of ([\d.]+)/.exec(await page.textContent('#log-position'))[1]);
for (let k = 0, at = from; at < to; at = from + ++k * step) {
  await page.mouse.click(line.x + at / seconds * line.width, line.y + line.height / 2);
  await shown(at);
  await page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));
  await page.waitForTimeout(300);  // the images are decoded
  await page.screenshot({path: `${folder}/${String(k).padStart(4, '0')}.png`});
}
await browser.close();
