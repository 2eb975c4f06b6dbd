// How long a page takes to show a log: node opened.mjs ADDRESS. Prints the seconds until the position and the first picture are shown.
import {open} from './browser.mjs';

const begin = Date.now();
const {browser, page} = await open(process.argv[2]);
const loaded = Date.now();
await page.waitForFunction(() => document.querySelector('#log-position')?.textContent.includes(' of ') && Number(document.querySelector('#time-line').dataset.pictures) > 0, null, {timeout: 120000});
console.log(JSON.stringify({browser_s: (loaded - begin) / 1000, shown_s: (Date.now() - begin) / 1000}));
await browser.close();
