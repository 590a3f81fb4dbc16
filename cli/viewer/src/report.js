// The page of `neural-mesh-bench evaluate`: reads the data that the program wrote into it, and wires up tables, plots and worst cases.

import { makePlots } from './plots.js';
import { pointsOf } from './points.js';
import { attempt, fail, markFirstDraw } from './stage.js';
import { fillFailures, fillOverall, fillSingle, STATISTICS } from './standings.js';
import { fillMeanings } from './table.js';
import { makeTheme } from './theme.js';
import { count, spoken } from './words.js';
import { makeWorst } from './worst.js';

const at = (id) => document.getElementById(id);

async function start() {
  const data = JSON.parse(at('evaluation').textContent);
  const { overview } = data;
  writeWords(data);
  const choice = { column: Math.max(overview.columns.findIndex(({ name }) => name === 'distance_mean'), 0), ratio: 0, statistic: 'median' };
  const worst = makeWorst(data);
  const plots = makePlots(data, pointsOf(data));
  const update = () => {
    fillSingle(overview, choice);
    fillOverall(overview, choice);
    return attempt(plots.show(choice));
  };
  wireChoices(overview, choice, update);
  fillFailures(overview, data.more_failures);
  makeTheme((colours) => {
    worst?.setTheme(colours);
    plots.setTheme();
  });
  await update();
  if (worst) await worst.start();
  else markFirstDraw();
}

function writeWords({ overview: { facts, columns, relative_to: other } }) {
  const { meshes, seeds, samples, runs, versions, machines, processes } = facts;
  at('facts').textContent = `${count(meshes)} ${meshes === 1 ? 'mesh' : 'meshes'}, ${seeds.length > 1 ? 'seeds' : 'seed'} ${seeds.join(', ')}`;
  fillMeanings(at('meanings'), columns);
  at('settings').textContent = `neural-mesh ${versions.join(', ')}. ${samples.map(count).join(', ')} samples on each surface. Times: `
    + `median of ${runs} ${runs === 1 ? 'run' : 'runs'} on ${machines.join('; ')}, of the method alone, without reading and writing files`
    + (processes.length > 0 ? `; of ${processes.join(', ')} of the whole process, with reading and writing.` : '.');
  at('how-cells').textContent = 'Click a column to sort by it. Each number summarises all meshes and seeds; a small number next to it counts '
    + 'the results with a value, if some have none.'
    + (other ? ` Quotients to ${other} are computed for each case in which both have a result; the table shows the median.` : '');
}

function wireChoices({ columns, ratios, relative_to: other }, choice, update) {
  const choose = (id, key, names, asValue) => {
    at(id).append(...names.map((name, i) => new Option(name, i)));
    at(id).value = choice[key];
    at(id).addEventListener('change', () => { choice[key] = asValue(at(id).value); update(); });
  };
  choose('figure', 'column', columns.map(({ name }) => spoken(name)), Number);
  choose('ratio', 'ratio', ratios.map(String), Number);
  for (const [key, words] of Object.entries(STATISTICS)) {
    if (key === 'quotient' && !other) continue;
    const input = Object.assign(document.createElement('input'), { type: 'radio', name: 'statistic', value: key, checked: key === choice.statistic });
    input.addEventListener('change', () => { choice.statistic = key; update(); });
    const label = Object.assign(document.createElement('label'), { className: 'chip' });
    label.append(input, words(other));
    at('statistics').append(label);
  }
}

attempt(start().catch(fail));
