// What the Khronos validator says about .glb files: node validate.js FILE...
// Prints the messages; ends with 1 if there is any above information.
import { readFile } from "node:fs/promises";
import validator from "gltf-validator";

const INFORMATION = 2;
let worst = INFORMATION;
for (const file of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), { uri: file });
  const { numErrors, numWarnings, numInfos, messages } = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} notes`);
  for (const { severity, code, message, pointer } of messages) {
    console.log(`  ${code} ${pointer ?? ""}: ${message}`);
    worst = Math.min(worst, severity);
  }
}
process.exit(worst < INFORMATION ? 1 : 0);
