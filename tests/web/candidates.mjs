// The candidates for a target on the page of a log that candidates_log.py wrote: node candidates.mjs ADDRESS [FOLDER FOR PICTURES].
import {checks, open} from './browser.mjs';

const [address, folder] = process.argv.slice(2);
const {browser, page, faults} = await open(address);
const {check, contains, finish} = checks(page);
await page.waitForFunction(() => Number(document.querySelector('#time-line')?.dataset.pictures) > 2);
const line = await page.locator('#time-line').boundingBox();
const goTo = part => page.mouse.click(line.x + part * line.width, line.y + line.height / 2);
/** How many pixels over the images are drawn on. */
const marked = () => page.evaluate(() => {
  const canvas = document.querySelector('#picture-marks');
  return canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.filter((value, i) => i % 4 === 3 && value > 0).length;
});

await goTo(0.3);
await contains('#candidates', 'chosen. For it: shape');
await contains('#candidates', 'not chosen: it was there before the target – 40 times less likely than 1');  // exp(3 + 0.3 + 0.2 + 0.2) = 40.4
await contains('#candidates', 'strongly background (−3.0)');
check(await page.locator('#candidates li').count() === 3, 'there are not three candidates');
check(await marked() > 500, 'the candidates are not marked in the images');
if (folder) await page.screenshot({path: `${folder}/candidates.png`});
await goTo(0.9);
await contains('#reach', 'ambiguous');
await contains('#candidates', 'not chosen: it could be the target as well – 1.5 times less likely than 1');
await finish(browser, faults);
