// Theme of the site: that of the system, until the button chooses another. On narrow displays the list of pages is closed.
(() => {
  const root = document.documentElement;
  const stored = () => { try { return localStorage.getItem("theme"); } catch { return null; } };
  const dark = () => (stored() ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
  const show = () => { root.dataset.theme = dark() ? "dark" : "light"; };
  show();
  addEventListener("DOMContentLoaded", () => {
    document.getElementById("theme").addEventListener("click", () => {
      try { localStorage.setItem("theme", dark() ? "light" : "dark"); } catch { /* not stored: files in some browsers */ }
      show();
    });
    if (matchMedia("(max-width: 52rem)").matches) document.getElementById("pages").open = false;
    document.querySelector("nav .current")?.scrollIntoView({ block: "nearest" });
  });
})();
