// How thoroughly each segment was searched, and with which effort.

import { percent } from "./describe.js";
import type { Mission, SegmentRow } from "./mission.js";
import { element } from "./panel.js";
import { distance } from "./place.js";

/** Updates the table; only changed cells are touched, so that a screen reader keeps its position. */
export function showSegments(mission: Mission): void {
  const body = element("segments", HTMLTableElement).tBodies[0];
  if (body === undefined) return;
  while (body.rows.length > mission.segments.length) body.deleteRow(-1);
  mission.segments.forEach((segment, index) => {
    const row = body.rows[index] ?? newRow(body);
    texts(segment).forEach((text, column) => {
      const cell = row.cells[column];
      if (cell !== undefined && cell.textContent !== text) cell.textContent = text;
    });
  });
}

function newRow(body: HTMLTableSectionElement): HTMLTableRowElement {
  const row = body.insertRow();
  const name = document.createElement("th");
  name.scope = "row";
  row.append(name);
  for (let column = 1; column < 9; column += 1) row.insertCell();
  return row;
}

function texts(segment: SegmentRow): string[] {
  const known = (value: number | null, write: (value: number) => string) => (value === null ? "–" : write(value));
  return [
    segment.name,
    percent(segment.poa),
    known(segment.poa_now, percent),
    percent(segment.pod),
    percent(segment.pos),
    known(segment.sweep_width_meters, (meters) => `${meters.toFixed(1)} m`),
    known(segment.track_meters, distance),
    known(segment.coverage, (coverage) => coverage.toFixed(2)),
    known(segment.area_square_meters, hectares),
  ];
}

function hectares(squareMeters: number): string {
  const area = squareMeters / 10_000;
  return `${area.toFixed(area < 10 ? 2 : area < 100 ? 1 : 0)} ha`;
}
