// Sounds: two of them in a loop and in step, of which one is heard.
(() => {
  const players = [...document.querySelectorAll(".recording audio")];
  for (const player of players) {
    const shown = player.closest(".recording").querySelector(".duration");
    const length = () => { if (Number.isFinite(player.duration)) shown.textContent = `${player.duration.toFixed(2)} s`; };
    player.addEventListener("loadedmetadata", length);
    if (player.readyState > 0) length();
  }
  const control = (name) => document.querySelector(`[data-ab="${name}"]`);
  if (!control("play")) return;
  let context = null, running = null, heard = "A";
  const buffers = new Map();
  const decoded = async (player) => {
    if (!buffers.has(player)) {
      const text = atob(player.src.split(",")[1]);
      buffers.set(player, await context.decodeAudioData(Uint8Array.from(text, (character) => character.charCodeAt(0)).buffer));
    }
    return buffers.get(player);
  };
  const gains = () => { for (const letter of ["A", "B"]) running.gain[letter].gain.setTargetAtTime(letter === heard ? 1 : 0, context.currentTime, 0.003); };
  const say = () => {
    control("now").textContent = running ? `plays ${heard}: ${players[control(heard).value].closest(".recording").dataset.name}` : "";
    control("play").textContent = running ? "stop" : "play A and B in a loop";
    control("switch").disabled = !running;
  };
  const stop = () => {
    if (running) for (const letter of ["A", "B"]) running.source[letter].stop();
    running = null;
    say();
  };
  const play = async () => {
    context ??= new AudioContext();
    await context.resume();
    const own = { source: {}, gain: {} };
    // Both last as long as the longer one, so that they stay in step.
    const sounds = await Promise.all(["A", "B"].map((letter) => decoded(players[control(letter).value])));
    const end = Math.max(...sounds.map((sound) => sound.duration)) + 0.15, start = context.currentTime + 0.05;
    ["A", "B"].forEach((letter, index) => {
      const sound = sounds[index];
      const padded = context.createBuffer(1, Math.ceil(end * sound.sampleRate), sound.sampleRate);
      padded.copyToChannel(sound.getChannelData(0), 0);
      const source = context.createBufferSource(), gain = context.createGain();
      source.buffer = padded;
      source.loop = true;
      gain.gain.value = letter === heard ? 1 : 0;
      source.connect(gain).connect(context.destination);
      source.start(start);
      Object.assign(own.source, { [letter]: source });
      Object.assign(own.gain, { [letter]: gain });
    });
    running = own;
    say();
  };
  control("play").addEventListener("click", () => { if (running) stop(); else play(); });
  control("switch").addEventListener("click", () => { heard = heard === "A" ? "B" : "A"; if (running) gains(); say(); });
  for (const letter of ["A", "B"]) control(letter).addEventListener("change", () => { if (running) { stop(); play(); } });
  say();
  window.nailnoise.sounds = { heard: () => running && { letter: heard, gains: ["A", "B"].map((letter) => running.gain[letter].gain.value) } };
})();
