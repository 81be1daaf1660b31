// Does the field above a table filter its rows, and give them back? Says what it does not.
(table) => {
  const tools = table.closest(".scroll").previousElementSibling, search = tools?.querySelector("input[type=search]");
  const shown = () => [...table.tBodies[0].rows].filter((row) => !row.hidden).length, type = (text) => {
    search.value = text;
    search.dispatchEvent(new Event("input"));
    return shown();
  };
  if (!search) return "a table to filter without a field";
  const before = shown();
  if (type("no row has this") !== 0) return "a filter that keeps what lacks its word";
  return type("") === before ? "" : "a filter that does not give back its rows";
}
