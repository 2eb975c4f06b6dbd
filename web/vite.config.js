import {defineConfig} from 'vite';

export default defineConfig({
  base: './',
  build: {outDir: '../build/web', emptyOutDir: true, assetsInlineLimit: 0, chunkSizeWarningLimit: 1000, modulePreload: {polyfill: false}},
});
