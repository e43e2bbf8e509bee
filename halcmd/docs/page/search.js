// Search of the manual: sections that have every word, those with the words in their heading first.
const field = document.getElementById("search");
const found = document.getElementById("found");
field.addEventListener("input", () => {
  const words = field.value.toLowerCase().split(/\s+/).filter((word) => word.length > 1);
  const rows = words.length === 0 ? [] : MANUAL.map(([at, chapter, title, text]) => {
    const heading = title.toLowerCase();
    const whole = `${heading} ${chapter.toLowerCase()} ${text.toLowerCase()}`;
    const count = words.every((word) => whole.includes(word)) ? 1 + words.filter((word) => heading.includes(word)).length : 0;
    return [count, at, chapter, title];
  }).filter(([count]) => count > 0).sort((a, b) => b[0] - a[0]);
  found.replaceChildren(...rows.slice(0, 12).map(([, at, chapter, title]) => {
    const link = document.createElement("a");
    link.href = at;
    link.textContent = chapter === title ? title : `${title} · ${chapter}`;
    return link;
  }));
});
