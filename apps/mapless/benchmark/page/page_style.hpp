#pragma once

namespace mapless::app {

/// The style sheet of the page.
inline constexpr const char* kPageStyle = R"css(
:root { color-scheme: light dark; --ink: #22262e; --soft: #5b6472; --line: #e2e5ea; --paper: #fafaf8; --card: #fff; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e7ec; --soft: #9aa4b2; --line: #2e343e; --paper: #12151a; --card: #181c22; }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
main { max-width: 64rem; margin: 0 auto; padding: 2.5rem 1.25rem 4rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .4rem; letter-spacing: -.01em; }
h2 { font-size: 1.25rem; margin: 3rem 0 .6rem; padding-top: 1.2rem; border-top: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.8rem 0 .5rem; }
p, li { max-width: 44rem; }
.soft, figcaption { color: var(--soft); font-size: .88rem; line-height: 1.4; }
.facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(8.5rem, 1fr)); gap: 1rem; margin: 1.6rem 0; }
.facts div { border-top: 2px solid var(--ink); padding-top: .5rem; }
.facts b { display: block; font-size: 1.55rem; font-weight: 600; font-variant-numeric: tabular-nums; }
.facts span { color: var(--soft); font-size: .85rem; }
.scroll { overflow-x: auto; margin: .8rem 0; }
table { border-collapse: collapse; font-size: .85rem; font-variant-numeric: tabular-nums; }
th, td { padding: .32rem .6rem; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line); }
th { color: var(--soft); font-weight: 500; border-bottom-color: var(--soft); }
th.w, td.w { text-align: left; }
tbody tr:hover { background: var(--card); }
figure { margin: 0; }
figcaption { margin-top: .35rem; }
img, iframe { display: block; width: 100%; height: auto; border: 1px solid var(--line); border-radius: 4px; }
iframe { height: 36rem; }
a { color: inherit; }
.plots { display: grid; gap: 1rem; margin: 1rem 0; }
.gallery, .cascade { display: grid; grid-template-columns: repeat(auto-fill, minmax(13.5rem, 1fr)); gap: 1rem; }
.cascade { grid-template-columns: repeat(auto-fit, minmax(11rem, 1fr)); }
.key { display: flex; flex-wrap: wrap; gap: .3rem 1.2rem; list-style: none; padding: 0; font-size: .9rem; }
.key i { display: inline-block; width: .75rem; height: .75rem; border-radius: 50%; margin-right: .4rem; vertical-align: -.05rem; }
details { margin: .8rem 0; } summary { cursor: pointer; color: var(--soft); }
code { font-size: .88em; }
)css";

}  // namespace mapless::app
