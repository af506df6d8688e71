// What a browser keeps of a viewer's choices, for later missions too.

/** A choice that was kept; null if there is none, or the browser keeps nothing. */
export function kept(name: string): string | null {
  try {
    return localStorage.getItem(`dragnet.${name}`);
  } catch {
    return null;
  }
}

/** Keeps a choice. Without storage it holds until the page is closed. */
export function keep(name: string, choice: string): void {
  try {
    localStorage.setItem(`dragnet.${name}`, choice);
  } catch {
    // Nothing is kept.
  }
}
