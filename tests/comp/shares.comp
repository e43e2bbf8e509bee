component shares "A symbol for other modules, and one that stays inside.";
pin out s32 out;
function _;
license "MIT";
;;
int shares_answer(void);
EXPORT_SYMBOL(shares_answer);
int shares_answer(void) { return 42; }
int shares_secret(void) { return 7; }
FUNCTION(_) { out = shares_answer() + shares_secret(); }
