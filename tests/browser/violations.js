// What axe-core finds against a page. What a rule finds has the impact that the rule states, so that the rules of less than
// serious impact are left out before they are asked: they take a quarter of the time. A rule that states none is asked.
// Where the page is not asked as a whole, a row of a table that is made as two above it are, class for class, is left out.
async (whole) => {
  const made = {}, alike = [];
  for (const row of whole ? [] : document.querySelectorAll("tbody tr")) {
    const tags = [...row.querySelectorAll("*")].map((one) => `${one.tagName}.${one.className}`);
    const kind = `${row.closest("table").className} ${row.className} ${row.dataset.status} ${tags}`;
    made[kind] = (made[kind] ?? 0) + 1;
    if (made[kind] > 2) alike.push(row);
  }
  const slight = axe._audit.rules.filter((rule) => ["minor", "moderate"].includes(rule.impact)).map((rule) => rule.id);
  const rules = Object.fromEntries(slight.map((id) => [id, { enabled: false }]));
  return (await axe.run({ include: [document], exclude: alike }, { resultTypes: ["violations"], preload: false, rules })).violations;
}
