export function kept(name) {
    try {
        return localStorage.getItem(`dragnet.${name}`);
    }
    catch {
        return null;
    }
}
export function keep(name, choice) {
    try {
        localStorage.setItem(`dragnet.${name}`, choice);
    }
    catch {
    }
}
