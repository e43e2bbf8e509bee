component told_well """Texts of every form.

With *emphasis*, **strong** words, \\fBold\\fR roff, and `code`.""";
pin in float in "A quoted \"text\", with a backslash \\ and a tab\tin it.";
pin out float out r"""Raw: \fBnothing\n is an escape.""";
pin out bit ok "Non-ASCII: 20 µm ≤ x, \x41\101\u00e9";
param rw float gain = 2.0 """
Of several lines,
with "quotes" in it.""";
function _ fp "Does it.";
description """
First paragraph.

Second, with a list:

* one
* two, with `gain`
""";
see_also "motion(9), \\fBboth\\fR(9)";
notes "Mind the edges.";
notes "There may be several.";
examples """
 loadrt told_well
 setp told-well.0.gain 3
""";
author "Somebody <some@where>";
license "MIT";
option default_count 2;
;;
out = in * gain;
ok = 1;
