// The rules for JavaScript. Run from the project's folder with the packages in build/interop.
const load = require('module').createRequire(require('path').resolve('build/interop/x.js'));
const js = load('@eslint/js');
const globals = load('globals');

const rules = {
  ...js.configs.recommended.rules,
  eqeqeq: 'error',
  'no-shadow': 'error',
  'no-use-before-define': ['error', {functions: false}],
  'no-var': 'error',
  'prefer-const': 'error',
  'no-console': 'off'
};

// Tests contain functions that run in the page.
const inTests = {...globals.node, ...globals.browser, gaitslamPage: 'readonly'};

module.exports = [
  {files: ['sim/**/*.js'], languageOptions: {globals: globals.browser}, rules},
  {files: ['tests/**/*.cjs'], languageOptions: {sourceType: 'commonjs', globals: inTests}, rules}
];
