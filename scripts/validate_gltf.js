// Prints what the Khronos validator counts in each file, and the first five; fails where one has errors.
const fs = require('fs');
const path = require('path');
const validator = require('gltf-validator');

async function judge(file) {
  const beside = (uri) => fs.promises.readFile(path.join(path.dirname(file), decodeURIComponent(uri)));
  const options = { uri: path.basename(file), maxIssues: 0, externalResourceFunction: async (uri) => new Uint8Array(await beside(uri)) };
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), options);
  const { numErrors, numWarnings, messages } = report.issues;
  console.log(`${file}: errors: ${numErrors}, warnings: ${numWarnings}`);
  for (const issue of messages.filter((issue) => issue.severity < 2).slice(0, 5)) {
    console.log(`  ${issue.severity === 0 ? 'error' : 'warning'} ${issue.code} ${issue.pointer}: ${issue.message}`);
  }
  return numErrors;
}

(async () => {
  let errors = 0;
  for (const file of process.argv.slice(2)) errors += await judge(file);
  console.log(`files: ${process.argv.length - 2}, errors: ${errors}`);
  process.exitCode = errors > 0 ? 1 : 0;
})();
