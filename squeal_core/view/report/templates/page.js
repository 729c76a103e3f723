'use strict';
// Draws the figures one after the other, in the colours of the reader's scheme; light on paper.
(() => {
  const figures = JSON.parse(document.getElementById('figures').textContent);
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const config = {responsive: true, displaylogo: false, scrollZoom: true};
  const PAPER = {wide: 980, half: 480, tall: 540, low: 250};  // px, on A4 across

  function template(isDark) {
    const [text, grid, zero] = isDark ? ['#e6edf3', '#30363d', '#6e7681']
      : ['#1b1f24', '#e1e4e8', '#8c959f'];
    const axis = {gridcolor: grid, zerolinecolor: grid, linecolor: zero, tickcolor: zero,
      showline: true, ticks: 'outside'};
    const solid = {gridcolor: grid, zerolinecolor: zero, color: text, showbackground: false};
    return {layout: {
      paper_bgcolor: 'rgba(0,0,0,0)', plot_bgcolor: 'rgba(0,0,0,0)', font: {color: text, size: 12},
      xaxis: axis, yaxis: axis, scene: {xaxis: solid, yaxis: solid, zaxis: solid},
      hoverlabel: {bgcolor: isDark ? '#161b22' : '#ffffff', bordercolor: zero,
        font: {color: text}}, legend: {bgcolor: 'rgba(0,0,0,0)'},
      modebar: {bgcolor: 'rgba(0,0,0,0)', color: zero, activecolor: text}}};
  }

  const plot = (figure) => document.getElementById(figure.id);
  const isSolid = (figure) => 'scene' in figure.layout;

  async function draw(figure) {
    await Plotly.newPlot(plot(figure), figure.data,
      {...figure.layout, template: template(dark.matches)}, config);
  }

  // WebGL leaves nothing on paper, so a picture of it is printed
  async function picture(figure) {
    const img = plot(figure).parentElement.querySelector('img.printed');
    img.src = await Plotly.toImage({data: figure.data, config,
      layout: {...figure.layout, template: template(false)}},
    {format: 'png', width: PAPER.half, height: PAPER.half, scale: 2});
  }

  const drawn = () => figures.filter((figure) => plot(figure).layout);

  function recolour() {
    drawn().forEach((figure) => Plotly.relayout(plot(figure), {template: template(dark.matches)}));
  }

  function toPaper() {
    drawn().filter((figure) => !isSolid(figure)).forEach((figure) => {
      const wide = plot(figure).parentElement.classList.contains('wide');
      Plotly.relayout(plot(figure), {template: template(false), autosize: false,
        width: wide ? PAPER.wide : PAPER.half,
        height: figure.layout.height > 600 ? PAPER.tall : PAPER.low});
    });
  }

  function toScreen() {
    drawn().filter((figure) => !isSolid(figure)).forEach((figure) => {
      Plotly.relayout(plot(figure), {template: template(dark.matches), autosize: true,
        width: null, height: figure.layout.height});
    });
  }

  // run as soon as the tables are on the screen: it takes longer than all before it
  function loadPlotly() {
    const script = document.createElement('script');
    const held = document.getElementById('plotly');
    if (!held.dataset.beside) {
      script.textContent = held.textContent;
      document.head.append(script);
      return null;
    }
    script.src = held.dataset.beside;
    document.head.append(script);
    return new Promise((done) => script.addEventListener('load', done));
  }

  async function start() {
    await loadPlotly();
    for (const figure of figures) {
      await draw(figure);
      await new Promise((done) => setTimeout(done));
    }
    document.documentElement.dataset.drawn = performance.now().toFixed(0);
    for (const figure of figures.filter(isSolid)) await picture(figure);
    document.documentElement.dataset.printable = 'yes';
    dark.addEventListener('change', recolour);
    addEventListener('beforeprint', toPaper);
    addEventListener('afterprint', toScreen);
  }

  requestAnimationFrame(() => setTimeout(start));
})();
