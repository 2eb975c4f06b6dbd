// A picture of the page of a running loop: node picture.mjs ADDRESS FILE [dark].
import {open} from './browser.mjs';

const [address, file, theme] = process.argv.slice(2);
const {browser, page} = await open(address, {theme});
const kSeconds = 5;  // of plots
await page.waitForFunction(() => document.querySelector('#reach').textContent.includes('mm away'));
await page.waitForTimeout(1000 * kSeconds);
await page.screenshot({path: file});
await browser.close();
