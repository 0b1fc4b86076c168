// What looks wrong on a page: each function returns the words at the place.
({
  // Words in a panel that lie upon each other, or outside of it.
  collisions: () => [...document.querySelectorAll('svg.panel')].flatMap(svg => {
    const edge = svg.getBoundingClientRect();
    const texts = [...svg.querySelectorAll('text:not([transform])')].map(text => {
      const {left, right, top, bottom} = text.getBoundingClientRect();
      return {words: text.textContent, left, right, top, bottom};
    }).filter(text => text.words.trim());
    const cut = texts.filter(t => t.left < edge.left - 1 || t.right > edge.right + 1);
    const pairs = texts.flatMap((a, i) => texts.slice(i + 1).filter(b =>
      Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 &&
      Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2
    ).map(b => [a.words, b.words]));
    return [...cut.map(text => text.words), ...pairs];
  }),
  // Rows that one must scroll sideways to read, and units on a line without their number.
  cut: () => [
    ...[...document.querySelectorAll('.scroll > table:not(.numbers)')].map(table => table.parentElement)
      .filter(box => box.scrollWidth > box.clientWidth),
    ...[...document.querySelectorAll('.pair .unit')].filter(unit =>
      unit.getBoundingClientRect().top > unit.parentElement.getBoundingClientRect().top + 30),
  ].map(one => one.textContent),
  small: () => [...document.querySelectorAll('svg.panel text')].filter(text => {
    const size = text.getBoundingClientRect();
    return text.textContent.trim() && size.height > 0 && size.height < 8 &&
      !text.hasAttribute('transform');
  }).map(text => text.textContent),
})
