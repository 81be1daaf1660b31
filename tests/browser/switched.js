// Does the first switch of a chart's legend hide marks, and bring them back? Says what it does not.
async (figure) => {
  const buttons = [...figure.querySelectorAll(".switches button")], count = () => [...figure.querySelectorAll(".plot svg .mark-symbol path, .plot svg .mark-rule line, .plot svg .mark-text text")]
    .filter((mark) => !mark.closest(".role-axis, .role-legend")).length;
  if (buttons.length < 2) return "";
  const before = count(), turn = async (pressed) => {
    buttons[0].click();
    for (let k = 0; k < 100; k++) {
      await new Promise((done) => setTimeout(done, 30));
      if (buttons[0].getAttribute("aria-pressed") === pressed && (pressed === "true" ? count() === before : count() < before)) return true;
    }
    return false;
  };
  if (!(await turn("false"))) return `${figure.id}: its first switch hides nothing`;
  return (await turn("true")) ? "" : `${figure.id}: its first switch does not bring back what it hid`;
}
